// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/imu/stationarity.h"

#include <algorithm>
#include <cmath>

#include "estimator/imu/stretch.h"

namespace facet {

Status StationarityConfig::validate() const { return validate_fields(kStationarityFields, *this); }

Status measure_stationarity(const ImuBuffer& buffer, Timestamp stamp, const RestingImu& imu,
                            const StationarityConfig& config, Stationarity& out) {
    const Timestamp begin = stamp - Duration::from_seconds(config.duration_s);
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
        config.margin * std::hypot(noise.gyro_noise_rad_per_s_per_sqrt_hz * root_rate, config.gyro_floor_rad_per_s);
    const double accel_limit =
        config.margin * std::hypot(noise.accel_noise_m_per_s2_per_sqrt_hz * root_rate, config.accel_floor_m_per_s2);
    const double gravity_error = std::abs((s.mean_a_B - imu.bias.accel).norm() - imu.gravity_m_per_s2);
    out.measure = std::max({s.gyro_std.maxCoeff() / gyro_limit, s.accel_std.maxCoeff() / accel_limit,
                            (s.mean_w_B - imu.bias.gyro).norm() / config.gyro_mean_rad_per_s,
                            gravity_error / config.gravity_error_m_per_s2,
                            s.drift_share(config.gyro_drift_rad_per_s, config.accel_drift_m_per_s2)});
    out.may_be_at_rest = out.measure < 1.0;
    return Status::kOk;
}

}  // namespace facet
