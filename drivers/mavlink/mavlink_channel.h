// SPDX-License-Identifier: BSD-2-Clause
// A serial line or a UDP socket that carries MAVLink.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "drivers/mavlink/mavlink_packet.h"
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

    /// Of a whole frame. A serial line that is nearly full may take a part of it: the rest is kept and goes before
    /// anything else, so that no frame is cut. @return kFull if the channel takes nothing of it now; kIo if it fails
    Status write(std::span<const std::uint8_t> bytes);
    /// Writes what is left of a frame. @return as write()
    Status flush();
    /// What has arrived: over UDP, one datagram. @param size  bytes read
    /// @return kNotReady if nothing has, kIo if the channel fails
    Status read(std::span<std::uint8_t> bytes, std::size_t& size);

    /// Waits until something may be read, or the channel has failed; not at all if it is not open.
    void wait(Duration timeout) {
        if (fd_ >= 0) {
            (void)io_.wait_readable(fd_, timeout);
        }
    }

    /// For messages.
    std::string name() const;

private:
    std::int64_t try_write(std::span<const std::uint8_t> bytes);
    Status open_udp(std::string& problem);
    Status open_serial(std::string& problem);

    KernelIo& io_;
    MavlinkChannelOptions options_;
    int fd_ = -1;
    MavlinkFrame rest_;  ///< of a frame that a serial line has taken a part of
};

}  // namespace facet
