// SPDX-License-Identifier: BSD-2-Clause
// Estimates and health as the frames of app/config/facet.dbc.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "drivers/common/can_frame.h"
#include "platform/base/timestamp.h"
#include "platform/port/odometry_sink.h"

namespace facet {

/// What goes out besides the estimate.
struct CanFrameInfo {
    std::uint32_t first_id = 0x3A0;  ///< 11 bits: that of FacetHealth, the others follow
    std::uint8_t count = 0;          ///< joins the frames of one estimate
    Duration age;                    ///< of the estimate now
    bool bit_rate_switch = false;    ///< of FD frames
};

/// The identifiers that are used, from CanFrameInfo::first_id on.
inline constexpr std::uint32_t kCanOutIds = 11;
inline constexpr std::size_t kClassicFrames = 9;

/// An estimate in classic frames of at most 8 bytes. Values outside of a signal's range become the nearest one in it.
/// W and B are ours: W z up, B as the vehicle file has it. Fields, ranges and units: app/config/facet.dbc.
/// @return kInvalidArgument if a number is not finite or a variance not positive: output untouched. Reentrant. No heap.
Status encode_classic(const Odometry& odometry, const CanFrameInfo& info, std::array<CanFrame, kClassicFrames>& frames);

/// The same in one CAN FD frame of 64 bytes, with a finer attitude.
Status encode_fd(const Odometry& odometry, const CanFrameInfo& info, CanFrame& frame);

/// What is sent to a bus whether there are estimates or not.
struct CanHealth {
    SinkState state = SinkState::kInit;
    int quality = 0;  ///< of the newest estimate
    std::uint8_t resets = 0;
    std::uint32_t reasons = 0;  ///< bits as in health.csv
    std::uint8_t alive = 0;     ///< 4 bits: one more in each frame
    Duration age = Duration::from_seconds(1e3);
};

/// FacetHealth, classic. Reentrant. No heap.
CanFrame encode_health(const CanHealth& health, std::uint32_t first_id);

}  // namespace facet
