// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/sim/vibration.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/support/rng.h"

namespace facet::sim {
namespace {

constexpr int kRotors = 4;
constexpr double kRise_s = 0.5;
constexpr double kTwoPi = 2.0 * std::numbers::pi;

/// Phases and strengths of one rotor.
struct Rotor {
    double mean_hz;
    double swing_hz;  ///< the frequency is mean + swing * sin(...)
    double swing_period_s;
    double swing_phase;
    Eigen::Array3d accel_phase;
    Eigen::Array3d gyro_phase;

    /// Integral of the frequency up to t, times 2 pi.
    double angle(double t_s) const {
        const double swing_rate = kTwoPi / swing_period_s;
        return kTwoPi * (mean_hz * t_s - swing_hz / swing_rate * std::cos(swing_rate * t_s + swing_phase));
    }
};

Rotor make_rotor(const Vibration& vibration, RandomStream& random) {
    const double width = vibration.high_hz - vibration.low_hz;
    Rotor rotor{};
    rotor.swing_hz = 0.15 * width;
    rotor.mean_hz = random.uniform(vibration.low_hz + rotor.swing_hz, vibration.high_hz - rotor.swing_hz);
    rotor.swing_period_s = random.uniform(1.0, 3.0);
    rotor.swing_phase = random.uniform(0.0, kTwoPi);
    for (int axis = 0; axis < 3; ++axis) {
        rotor.accel_phase[axis] = random.uniform(0.0, kTwoPi);
        rotor.gyro_phase[axis] = random.uniform(0.0, kTwoPi);
    }
    return rotor;
}

}  // namespace

void add_vibration(const Vibration& vibration, double from_s, std::uint64_t seed, std::span<ImuRecord> records) {
    RandomStream random(seed, 22);
    Rotor rotors[kRotors];
    for (Rotor& rotor : rotors) {
        rotor = make_rotor(vibration, random);
    }
    // A sum of n sinusoids of amplitude a and unrelated phases has the rms a sqrt(n / 2).
    const double per_rms = std::sqrt(2.0 / kRotors);
    for (ImuRecord& record : records) {
        const double rise = std::clamp((record.t_s - from_s) / kRise_s, 0.0, 1.0);
        if (rise <= 0.0) {
            continue;
        }
        Eigen::Array3d sum_accel = Eigen::Array3d::Zero();
        Eigen::Array3d sum_gyro = Eigen::Array3d::Zero();
        for (const Rotor& rotor : rotors) {
            const double angle = rotor.angle(record.t_s);
            sum_accel += (angle + rotor.accel_phase).sin();
            sum_gyro += (angle + rotor.gyro_phase).sin();
        }
        record.sample.a_B += (rise * vibration.accel_rms_m_per_s2 * per_rms * sum_accel).matrix();
        record.sample.w_B += (rise * vibration.gyro_rms_rad_per_s * per_rms * sum_gyro).matrix();
    }
}

}  // namespace facet::sim
