// SPDX-License-Identifier: BSD-2-Clause
// Estimates onto a CAN bus.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <string>

#include "drivers/can_out/estimate_frames.h"
#include "drivers/common/can_socket.h"
#include "drivers/common/retry_gate.h"
#include "platform/port/clock.h"

namespace facet {

enum class CanOutFormat : std::uint8_t {
    kAuto,     ///< FD if the interface is set up for it, else classic
    kClassic,  ///< several frames an estimate
    kFd,       ///< one frame an estimate
};

struct CanOutOptions {
    std::string interface = "can0";
    CanOutFormat format = CanOutFormat::kAuto;
    bool bit_rate_switch = true;     ///< of FD frames
    std::uint32_t first_id = 0x3A0;  ///< see CanFrameInfo
    int every = 1;                   ///< of so many estimates one is sent
    bool send_lost = false;          ///< poses of an estimator that is lost, with quality -1
    std::uint8_t node_id = 0;        ///< of DroneCAN, whose NodeStatus is sent then; 0: none
    Duration health_period = Duration::from_seconds(0.1);
    Duration status_period = Duration::from_seconds(1.0);  ///< of NodeStatus; 1 s is the longest allowed
    Duration retry_period = Duration::from_seconds(1.0);   ///< pause before an interface that failed is tried again
};

struct CanOutCounters {
    std::uint64_t frames = 0;             ///< sent
    std::uint64_t estimates = 0;          ///< sent whole
    std::uint64_t estimates_dropped = 0;  ///< of which at least one frame was not taken
    std::uint64_t lost_poses = 0;         ///< held back because the estimator was lost
    std::uint64_t queue_full = 0;         ///< frames that found the queue full
    std::uint64_t bus_off = 0;            ///< times that the controller left the bus
    std::uint64_t failures = 0;           ///< times that the interface was down or gone
};

/// Sends frames as app/config/facet.dbc describes them; what happens when: drivers/can_out/README.md. Nothing waits: a
/// frame that the queue does not take is dropped, and with it the rest of its estimate. Thread-bound, except
/// sent_resets(). Heap only if opening fails.
class CanOut final : public OdometrySink {
public:
    CanOut(KernelIo& io, const Clock& clock, CanOutOptions options);

    /// @return as CanSocket::open; `problem` has the words
    Status open(std::string& problem);
    void close() { socket_.close(); }
    /// Before the first pose: see MavlinkLink.
    void begin_resets_at(std::uint8_t first) {
        first_reset_ = first;
        sent_resets_.store(first, std::memory_order_relaxed);
    }

    /// Status::kOk also if the pose is held back on purpose; kFull if the bus does not take it.
    Status send(const Odometry& odometry) override;
    void report(const StateChange& change) override;
    void service() override;
    Duration service_period() const override { return Duration::from_seconds(0.01); }

    /// Such as "can0, CAN FD". After open().
    std::string name() const;
    const CanOutCounters& counters() const { return counters_; }
    /// The reset counter of the newest pose. On any thread.
    std::uint8_t sent_resets() const { return sent_resets_.load(std::memory_order_relaxed); }

private:
    Status send_frame(const CanFrame& frame);
    Status send_estimate(const Odometry& odometry);
    bool is_usable();
    void read_errors();
    void send_health();

    const Clock& clock_;
    CanOutOptions options_;
    CanSocket socket_;
    RetryGate retry_;
    CanOutCounters counters_;
    std::array<CanFrame, kClassicFrames> frames_;
    CanHealth health_;
    Timestamp newest_;  ///< stamp of the newest estimate
    bool any_ = false;
    bool is_bus_off_ = false;
    int skipped_ = 0;  ///< estimates since the one that was sent
    std::uint8_t count_ = 0;
    std::uint8_t transfer_ = 0;
    std::uint8_t first_reset_ = 0;
    Timestamp begin_;
    Timestamp next_health_;
    Timestamp next_status_;
    std::atomic<std::uint8_t> sent_resets_{0};
};

}  // namespace facet
