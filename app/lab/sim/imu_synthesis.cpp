// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/sim/imu_synthesis.h"

#include <cmath>

#include "app/support/rng.h"

namespace facet::sim {
namespace {

constexpr double kInitialGyroBias_rad_per_s = 0.03;
constexpr double kInitialAccelBias_m_per_s2 = 0.06;

Eigen::Vector3d normal3(RandomStream& random) {
    const double x = random.normal();
    const double y = random.normal();
    return {x, y, random.normal()};
}

}  // namespace

std::vector<ImuRecord> synthesise_imu(const Flight& flight, double end_s, Timestamp epoch, const ImuModel& model,
                                      std::uint64_t seed) {
    const ImuNoise* const noise = model.noise;
    const double rate_hz = model.rate_hz;
    const Eigen::Vector3d g_W = gravity_W(model.gravity_m_per_s2);
    RandomStream random(seed, 21);
    const double dt = 1.0 / rate_hz;
    const auto count = static_cast<int>(std::floor(end_s * rate_hz + 1e-9)) + 1;
    ImuBias bias;
    if (noise != nullptr) {
        bias.gyro = kInitialGyroBias_rad_per_s * normal3(random);
        bias.accel = kInitialAccelBias_m_per_s2 * normal3(random);
    }
    std::vector<ImuRecord> records;
    records.reserve(static_cast<std::size_t>(count));
    for (int k = 0; k < count; ++k) {
        ImuRecord r;
        r.t_s = k * dt;
        r.state = flight.evaluate(r.t_s);
        r.bias = bias;
        r.sample.stamp = epoch + Duration::from_seconds(r.t_s);
        r.sample.w_B = r.state.w_B + bias.gyro;
        r.sample.a_B = r.state.T_W_B.q.conjugate() * (r.state.a_W - g_W) + bias.accel;
        if (noise != nullptr) {
            r.sample.w_B += noise->gyro_noise_rad_per_s_per_sqrt_hz * std::sqrt(rate_hz) * normal3(random);
            r.sample.a_B += noise->accel_noise_m_per_s2_per_sqrt_hz * std::sqrt(rate_hz) * normal3(random);
            bias.gyro += noise->gyro_walk_rad_per_s2_per_sqrt_hz * std::sqrt(dt) * normal3(random);
            bias.accel += noise->accel_walk_m_per_s3_per_sqrt_hz * std::sqrt(dt) * normal3(random);
        }
        records.push_back(r);
    }
    return records;
}

}  // namespace facet::sim
