// SPDX-License-Identifier: BSD-2-Clause
// MAVLink 2 frames of the two messages that are sent.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "platform/base/fixed_vector.h"
#include "platform/port/odometry_sink.h"

namespace facet {

/// CRC-16/MCRF4XX ("X.25" in MAVLink): polynomial 0x1021 reflected, initial 0xFFFF, no final inversion.
std::uint16_t mavlink_crc(std::span<const std::uint8_t> bytes, std::uint16_t initial = 0xFFFF);

struct MavlinkAddress {
    std::uint8_t system = 1;       ///< of the vehicle
    std::uint8_t component = 197;  ///< MAV_COMP_ID_VISUAL_INERTIAL_ODOMETRY
};

/// A whole frame: header 10, payload up to 255, checksum 2 bytes.
using MavlinkFrame = FixedVector<std::uint8_t, 267>;

/// ODOMETRY (331), frames LOCAL_FRD and BODY_FRD, estimator type VIO. Source: MAVLink common.xml, serialization guide.
///   p_F = D p_W,  v_b = D R_W_B^T v_W,  q_F_b = D q_W_B D,  D = diag(1, -1, -1)
/// W (z up, yaw zero at the start) and B (x forward, y left, z up) are turned about x into FRD frames. The velocity is
/// in the child frame. Covariances are upper triangles with rows x y z roll pitch yaw; orientation is perturbed on the
/// right, in B, as in the estimator, and position in the local frame. The covariance of velocity is rotated into B; its
/// cross terms with the rates are zero.
/// @return kInvalidArgument if a number is not finite or a variance not positive: frame untouched. Reentrant. No heap.
Status encode_odometry(const Odometry& odometry, const MavlinkAddress& address, std::uint8_t sequence,
                       MavlinkFrame& frame);

/// HEARTBEAT (0) of an onboard controller that is not an autopilot. Reentrant. No heap.
void encode_heartbeat(const MavlinkAddress& address, std::uint8_t sequence, MavlinkFrame& frame);

}  // namespace facet
