// SPDX-License-Identifier: BSD-2-Clause
// Inertial samples of a flight, exact or with noise and wandering bias.
#pragma once

#include <cstdint>
#include <vector>

#include "app/lab/sim/flight.h"
#include "estimator/imu/preintegration.h"
#include "estimator/values/imu_noise.h"
#include "estimator/values/nav_state.h"
#include "platform/base/samples.h"

namespace facet::sim {

/// A sample with the truth it was made from.
struct ImuRecord {
    double t_s = 0.0;  ///< time in the flight
    ImuSample sample;  ///< stamp = epoch + t
    FlightState state;
    ImuBias bias;  ///< in the sample
};

/// The IMU and where it is.
struct ImuModel {
    const ImuNoise* noise = nullptr;  ///< nullptr: exact samples without bias
    double rate_hz = 200.0;
    double gravity_m_per_s2 = 9.81;
};

/// Samples at k / rate from 0 to the last tick not after end_s:
///   w = w_B + bg + n,  a = R_W_B^T (a_W - g) + ba + n
/// White noise of standard deviation density * sqrt(rate); the bias starts at a value drawn once (gyroscope about
/// 0.03 rad/s, accelerometer 0.06 m/s^2, as on EuRoC's sensor) and takes a random walk of density * sqrt(dt) per
/// sample. Heap.
std::vector<ImuRecord> synthesise_imu(const Flight& flight, double end_s, Timestamp epoch, const ImuModel& model,
                                      std::uint64_t seed);

}  // namespace facet::sim
