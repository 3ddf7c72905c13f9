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

/// Sensors that are played. The first three are on SPI, the next two on CAN; the kernel itself drives the last (IIO).
enum class ImuKind : std::uint8_t { kIcm42688, kAdis16475, kBmi088, kDroneCan, kOpenImu300, kIio };
inline constexpr std::array<std::string_view, 6> kImuNames{"icm42688", "adis16475",  "bmi088",
                                                           "dronecan", "openimu300", "iio"};

constexpr bool is_on_can(ImuKind kind) { return kind == ImuKind::kDroneCan || kind == ImuKind::kOpenImu300; }

/// FIFO packet 4 of TDK DS-000347: 20 bits, 16 g and 2000 deg/s for 2^19; values beyond are clipped.
std::array<std::uint8_t, 20> icm_packet(const ImuSample& sample, std::uint16_t time_us);

/// Burst of the ADIS16475-2: DIAG_STAT, rates (40 LSB/(deg/s)), forces (4000 LSB/g), temperature, counter and the sum
/// of the bytes.
std::array<std::uint8_t, 20> adis_burst(const ImuSample& sample, std::uint16_t counter);

/// BMI088: age of the accelerometer's newest sample at an edge of the gyroscope. The two dies have no common clock;
/// here the accelerometer's 1600 Hz keep their distance from the edges, in the middle of a tick of its sensor time.
inline constexpr Duration kBmiForceAge{332'031};
/// What its driver takes that age for, in whole ticks.
inline constexpr Duration kBmiForceAgeRead{312'500};

/// Registers of both dies at an edge of the gyroscope: rates (2000 deg/s), forces (12 g) and the sensor time.
/// @param force  when the accelerometer measured last
/// @param count  of edges
std::array<std::uint8_t, 15> bmi_registers(const ImuSample& rate, const Eigen::Vector3d& force, std::uint32_t count);

/// The specific force of a log at an instant, between its samples. @param before  index of the last sample at or before
Eigen::Vector3d force_at(const std::vector<ImuSample>& samples, std::size_t before, Timestamp stamp);

/// One transfer of uavcan.equipment.ahrs.RawIMU: 7 classic frames, integrals over `interval` (float32), no covariance.
/// The sample is the mean over the interval, which ends half of it after the sample's stamp.
std::vector<CanFrame> dronecan_frames(const ImuSample& sample, Duration interval, std::uint8_t transfer);

/// Angular rate (1/128 deg/s), then acceleration (0.01 m/s^2), as the OpenIMU300RI sends them by J1939.
std::vector<CanFrame> openimu_frames(const ImuSample& sample);

/// What tests/hil/kernel/facet_hil/iio_imu.c measures: rates (2000 deg/s for 2^19, 20 bits), then forces (16 g for
/// 2^15, 16 bits), in the axes of a sensor that is turned by a quarter about z; values beyond are clipped.
std::array<std::int32_t, 6> iio_counts(const ImuSample& sample);

/// The samples after they have been encoded and decoded: what a replay must be given for the estimates to be the same.
/// CAN frames pass through the drivers' own decoders. The forces of a BMI088 are interpolated, so that its last sample
/// never comes.
std::vector<ImuSample> as_encoded(ImuKind kind, const std::vector<ImuSample>& samples, Duration interval);

}  // namespace facet::hil
