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
    kBothDropped,   ///< the same of both
    kTorn,          ///< the lower half of the left image is the one before's, and nobody says so
    kShort,         ///< left buffers with half of the bytes
    kFlagged,       ///< left buffers with the error flag
    kEdgesLost,     ///< trigger edges that vanish without a trace
    kEdgesExtra,    ///< a second edge half a period after each
    kUnplugged,     ///< the left camera's node goes and comes back, counting from zero
    kImuSilent,     ///< no samples, no edges
    kImuDamaged,    ///< every second sample has a wrong bit: checksum, header or transfer CRC
    kImuDead,       ///< SPI: nobody drives the line, edges go on
    kCanLoss,       ///< a third of the frames, in bursts of ten
    kBusOff,        ///< error frame, silence, frame of the restarted controller
    kCanDown,       ///< the interface goes down and up again
    kCount
};
inline constexpr std::array<std::string_view, static_cast<std::size_t>(FaultKind::kCount)> kFaultNames{
    "left_dropped",   "right_dropped", "both_dropped", "torn",      "short_frames",
    "flagged_frames", "edges_lost",    "edges_extra",  "unplugged", "imu_silent",
    "imu_damaged",    "imu_dead",      "can_loss",     "bus_off",   "can_down"};

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
