// SPDX-License-Identifier: BSD-2-Clause
// Inertial samples as the sensors of the tests send them.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "drivers/common/can_frame.h"
#include "platform/base/samples.h"

namespace facet::hil {

/// Sensors that are played. The first two are on SPI, the others on CAN.
enum class ImuKind : std::uint8_t { kIcm42688, kAdis16475, kDroneCan, kOpenImu300 };
inline constexpr std::array<std::string_view, 4> kImuNames{"icm42688", "adis16475", "dronecan", "openimu300"};

constexpr bool is_on_can(ImuKind kind) { return kind == ImuKind::kDroneCan || kind == ImuKind::kOpenImu300; }

/// FIFO packet 4 of TDK DS-000347: 20 bits, 16 g and 2000 deg/s for 2^19; values beyond are clipped.
std::array<std::uint8_t, 20> icm_packet(const ImuSample& sample, std::uint16_t time_us);

/// Burst of the ADIS16475-2: DIAG_STAT, rates (40 LSB/(deg/s)), forces (4000 LSB/g), temperature, counter and the sum
/// of the bytes.
std::array<std::uint8_t, 20> adis_burst(const ImuSample& sample, std::uint16_t counter);

/// One transfer of uavcan.equipment.ahrs.RawIMU: 7 classic frames, integrals over `interval` (float32), no covariance.
/// The sample is the mean over the interval, which ends half of it after the sample's stamp.
std::vector<CanFrame> dronecan_frames(const ImuSample& sample, Duration interval, std::uint8_t transfer);

/// Angular rate (1/128 deg/s), then acceleration (0.01 m/s^2), as the OpenIMU300RI sends them by J1939.
std::vector<CanFrame> openimu_frames(const ImuSample& sample);

/// The sample after it has been encoded and decoded: what a replay must be given for the estimates to be the same.
/// CAN frames pass through the drivers' own decoders.
ImuSample as_encoded(ImuKind kind, const ImuSample& sample, Duration interval);

}  // namespace facet::hil
