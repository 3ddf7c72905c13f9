// SPDX-License-Identifier: BSD-2-Clause
// A serial line or a UDP socket that carries MAVLink.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "platform/base/status.h"
#include "platform/port/kernel_io.h"

namespace facet {

struct MavlinkChannelOptions {
    std::string udp_host = "127.0.0.1";  ///< IPv4 address in digits
    std::uint16_t udp_port = 14580;      ///< where PX4 in simulation listens; 14540 is what it sends to
    std::uint16_t udp_local_port = 0;    ///< that datagrams are sent from and received at; 0: any
    std::string serial;                  ///< device such as /dev/ttyS1, 8N1 without flow control; empty: UDP
    int baud = 921600;
};

/// Never blocks. Over UDP only what the configured host sends from the configured port is received. Thread-bound. Heap
/// only in open(), if it fails.
class MavlinkChannel {
public:
    MavlinkChannel(KernelIo& io, MavlinkChannelOptions options);
    ~MavlinkChannel() { close(); }
    MavlinkChannel(const MavlinkChannel&) = delete;
    MavlinkChannel& operator=(const MavlinkChannel&) = delete;

    /// @param problem  set on failure
    /// @return kInvalidArgument if the address is invalid, kNotFound if there is no such serial device, kIo if the
    ///         system refuses
    Status open(std::string& problem);
    void close();
    bool is_open() const { return fd_ >= 0; }
    bool is_serial() const { return !options_.serial.empty(); }

    /// @return kFull if the channel does not take all of it now; a serial line may then have taken a part. kIo if it
    ///         fails
    Status write(std::span<const std::uint8_t> bytes);
    /// What has arrived: over UDP, one datagram. @param size  bytes read
    /// @return kNotReady if nothing has, kIo if the channel fails
    Status read(std::span<std::uint8_t> bytes, std::size_t& size);

    /// For messages.
    std::string name() const;

private:
    Status open_udp(std::string& problem);
    Status open_serial(std::string& problem);

    KernelIo& io_;
    MavlinkChannelOptions options_;
    int fd_ = -1;
};

}  // namespace facet
