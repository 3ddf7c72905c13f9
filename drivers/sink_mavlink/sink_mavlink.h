// SPDX-License-Identifier: BSD-2-Clause
// Sends estimates to a flight controller by MAVLink over UDP or a serial line.
#pragma once

#include <string>

#include "drivers/common/retry_gate.h"
#include "drivers/sink_mavlink/mavlink_frame.h"
#include "platform/port/clock.h"
#include "platform/port/kernel_io.h"

namespace facet {

struct SinkMavlinkOptions {
    MavlinkAddress address;
    std::string udp_host = "127.0.0.1";  ///< IPv4 address in digits
    std::uint16_t udp_port = 14540;
    std::string serial;  ///< device such as /dev/ttyS1, 8N1 without flow control; empty: UDP
    int baud = 921600;
    Duration heartbeat_period = Duration::from_seconds(1.0);
    Duration retry_period = Duration::from_seconds(1.0);  ///< pause before a failed serial line is reopened
};

/// Sends ODOMETRY at every estimate and HEARTBEAT once a second, and never blocks: what a full channel does not accept
/// is dropped and counted. A serial line may cut a frame off in the middle; the receiver notices by the checksum.
/// Thread-bound. Heap only if open fails.
class SinkMavlink final : public OdometrySink {
public:
    SinkMavlink(KernelIo& io, const Clock& clock, SinkMavlinkOptions options);
    ~SinkMavlink() override { close(); }
    SinkMavlink(const SinkMavlink&) = delete;
    SinkMavlink& operator=(const SinkMavlink&) = delete;

    /// @param problem  set on failure
    /// @return kInvalidArgument if the address is invalid, kNotFound if there is no such serial device, kIo if the
    ///         system
    ///         refuses
    Status open(std::string& problem);
    void close();
    Status send(const Odometry& odometry) override;

    std::uint64_t sent() const { return sent_; }
    std::uint64_t dropped() const { return dropped_; }

    /// Name of the channel, for messages.
    std::string name() const;

private:
    Status open_udp(std::string& problem);
    Status open_serial(std::string& problem);
    Status write();

    KernelIo& io_;
    const Clock& clock_;
    SinkMavlinkOptions options_;
    int fd_ = -1;
    MavlinkFrame frame_;
    std::uint8_t sequence_ = 0;
    Timestamp next_heartbeat_;
    RetryGate retry_;
    std::uint64_t sent_ = 0;
    std::uint64_t dropped_ = 0;
};

}  // namespace facet
