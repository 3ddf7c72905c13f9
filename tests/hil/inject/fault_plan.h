// SPDX-License-Identifier: BSD-2-Clause
// What goes wrong, and when.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "platform/base/timestamp.h"

namespace facet::hil {

enum class FaultKind : std::uint8_t {
    kLeftDropped,   ///< frames that the camera has counted and never gives
    kRightDropped,  ///< the same
    kRightStalled,  ///< frames that the right camera does not even count
    kRightLate,     ///< the right camera exposes, and stamps, 20 ms later
    kBothDropped,   ///< the same of both
    kTorn,          ///< the lower half of the left image is the one before's, and nobody says so
    kShort,         ///< left buffers with half of the bytes
    kFlagged,       ///< left buffers with the error flag
    kAhead,         ///< left frames stamped an hour ahead
    kEdgesLost,     ///< trigger edges that vanish without a trace
    kEdgesExtra,    ///< a second edge half a period after each
    kUnplugged,     ///< the left camera's node goes and comes back, counting from zero
    kImuSilent,     ///< no samples, no edges
    kImuDamaged,    ///< every second sample has a wrong bit: checksum, header or transfer CRC
    kImuDead,       ///< SPI: nobody drives the line, edges go on
    kImuBrownOut,   ///< SPI: no power; afterwards the registers are as after power-on
    kImuUnplugged,  ///< IIO: the device goes and comes back, as after power-on
    kReadyMerged,   ///< SPI: of two data-ready edges the first leaves no trace, as when the kernel's thread is late
    kCanLoss,       ///< a third of the frames, in bursts of ten
    kBusOff,        ///< error frame, silence, frame of the restarted controller
    kCanDown,       ///< the interface goes down and up again
    kClock30s,      ///< the wall clock is set, once: 30 s on
    kClock1h,       ///< an hour on
    kClockBack10s,  ///< 10 s back
    kDim,           ///< a tenth of the light, of cameras whose exposure is set
    kSinksHang,     ///< the thread of the sinks stops, once, as in a driver that never returns
    kStopped,       ///< the program is stopped (SIGSTOP), once; it runs again when its service manager restarts it
    kKilled,        ///< the program is killed (SIGKILL), once
    kPowerCut,      ///< the computer loses its power: nothing is written that was not synchronised with the disc
    kCount
};
inline constexpr std::array<std::string_view, static_cast<std::size_t>(FaultKind::kCount)> kFaultNames{
    "left_dropped", "right_dropped",  "right_stalled", "right_late",    "both_dropped",  "torn",
    "short_frames", "flagged_frames", "left_ahead",    "edges_lost",    "edges_extra",   "unplugged",
    "imu_silent",   "imu_damaged",    "imu_dead",      "imu_brown_out", "imu_unplugged", "ready_merged",
    "can_loss",     "bus_off",        "can_down",      "clock_30s",     "clock_1h",      "clock_back_10s",
    "dim",          "sinks_hang",     "stopped",       "killed",        "power_cut"};

struct Fault {
    FaultKind kind = FaultKind::kCount;
    Duration begin;  ///< since the first frame
    Duration end;
};

class FaultPlan {
public:
    /// "KIND@START+LENGTH" in seconds, such as "imu_silent@5+0.3". Throws std::runtime_error.
    void add(const std::string& text);
    bool active(FaultKind kind, Duration since_first_frame) const;
    const std::vector<Fault>& faults() const { return faults_; }

private:
    std::vector<Fault> faults_;
};

}  // namespace facet::hil
