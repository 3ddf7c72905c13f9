// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/imu/stationarity.h"

#include <algorithm>
#include <cmath>

#include "estimator/imu/stretch.h"

namespace facet {
namespace {

// At rest the standard deviations are below this many times the sensor's noise combined with the floor.
constexpr double kMargin = 3.0;
// Largest change of the mean specific force at rest between the halves of the examined data, beyond noise: less
// than the slowest sway of a hand (m/s^2).
constexpr double kAccelDrift_m_per_s2 = 0.015;
// Largest change of the mean rate at rest between the halves of the examined data, beyond noise (rad/s).
constexpr double kGyroDrift_rad_per_s = 0.003;
// Largest difference at rest between g and the mean specific force without bias: errors of bias and scale (m/s^2).
constexpr double kGravityError_m_per_s2 = 0.3;
// Largest mean rate at rest after subtracting the bias: the error of the bias estimate (rad/s).
constexpr double kGyroMean_rad_per_s = 0.02;
// Standard deviation of the acceleration that fans and wind cause on a vehicle at rest (m/s^2).
constexpr double kAccelFloor_m_per_s2 = 0.03;
// Standard deviation of the rate that fans and wind cause on a vehicle at rest (rad/s).
constexpr double kGyroFloor_rad_per_s = 0.003;

}  // namespace

Status measure_stationarity(const ImuBuffer& buffer, Timestamp stamp, const RestingImu& imu, Stationarity& out) {
    const Timestamp begin = stamp - Duration::from_seconds(kRestDuration_s);
    if (buffer.empty() || buffer.oldest() > begin) {
        return Status::kNotReady;
    }
    StretchStatistics s;
    FACET_TRY(stretch_statistics(buffer, begin, stamp, s));
    if (!s.is_whole) {
        return Status::kDegenerate;
    }
    const ImuNoise& noise = imu.noise;
    const double root_rate = std::sqrt(noise.rate_hz);
    const double gyro_limit =
        kMargin * std::hypot(noise.gyro_noise_rad_per_s_per_sqrt_hz * root_rate, kGyroFloor_rad_per_s);
    const double accel_limit =
        kMargin * std::hypot(noise.accel_noise_m_per_s2_per_sqrt_hz * root_rate, kAccelFloor_m_per_s2);
    const double gravity_error = std::abs((s.mean_a_B - imu.bias.accel).norm() - imu.gravity_m_per_s2);
    out.measure =
        std::max({s.gyro_std.maxCoeff() / gyro_limit, s.accel_std.maxCoeff() / accel_limit,
                  (s.mean_w_B - imu.bias.gyro).norm() / kGyroMean_rad_per_s, gravity_error / kGravityError_m_per_s2,
                  s.drift_share(kGyroDrift_rad_per_s, kAccelDrift_m_per_s2)});
    out.may_be_at_rest = out.measure < 1.0;
    return Status::kOk;
}

}  // namespace facet
