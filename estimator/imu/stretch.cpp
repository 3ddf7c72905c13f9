// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/imu/stretch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace facet {
namespace {

constexpr int kMinSamples = 4;
constexpr double kDriftSigmas = 4.0;

using Axes = Eigen::Array<double, 6, 1>;

Axes axes_of(const ImuSample& s) {
    Axes out;
    out << s.w_B, s.a_B;
    return out;
}

}  // namespace

double StretchStatistics::drift_sigma(double step_std) const {
    return step_std * std::sqrt(4.0 / std::max(1, samples));
}

double StretchStatistics::drift_share(double gyro_allowance, double accel_allowance) const {
    double share = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
        share = std::max(
            {share, std::abs(gyro_drift[axis]) / (gyro_allowance + kDriftSigmas * drift_sigma(gyro_step_std[axis])),
             std::abs(accel_drift[axis]) / (accel_allowance + kDriftSigmas * drift_sigma(accel_step_std[axis]))});
    }
    return share;
}

Status stretch_statistics(const ImuBuffer& buffer, Timestamp begin, Timestamp end, StretchStatistics& out) {
    StretchStatistics s;
    const Timestamp middle = begin + Duration{(end - begin).ns / 2};
    Axes early = Axes::Zero();
    Axes late = Axes::Zero();
    int early_samples = 0;
    FACET_TRY(buffer.for_each_step(begin, end, [&](const ImuSample&, const ImuSample& b, const ImuStepQuality& q) {
        s.is_whole = s.is_whole && q.gap == Duration{} && q.clipped == 0;
        ++s.samples;
        early_samples += b.stamp <= middle ? 1 : 0;
        (b.stamp <= middle ? early : late) += axes_of(b);
    }));
    if (s.samples < kMinSamples || early_samples == 0 || early_samples == s.samples) {
        return Status::kNotReady;
    }
    const Axes mean = (early + late) / s.samples;
    const Axes drift = late / (s.samples - early_samples) - early / early_samples;
    Axes squares = Axes::Zero();
    Axes steps = Axes::Zero();
    int step_count = 0;
    Axes last = Axes::Zero();
    FACET_TRY(buffer.for_each_step(begin, end, [&](const ImuSample&, const ImuSample& b, const ImuStepQuality&) {
        squares += (axes_of(b) - mean).square();
        if (step_count > 0) {
            steps += (axes_of(b) - last).square();
        }
        last = axes_of(b);
        ++step_count;
    }));
    const Axes std = (squares / (s.samples - 1)).sqrt();
    const Axes step_std = (steps / (2 * (s.samples - 1))).sqrt();
    s.mean_w_B = mean.head<3>();
    s.mean_a_B = mean.tail<3>();
    s.gyro_std = std.head<3>();
    s.accel_std = std.tail<3>();
    s.gyro_step_std = step_std.head<3>();
    s.accel_step_std = step_std.tail<3>();
    s.gyro_drift = drift.head<3>();
    s.accel_drift = drift.tail<3>();
    out = s;
    return Status::kOk;
}

Status tapered_means(const ImuBuffer& buffer, Timestamp begin, Timestamp end, TaperedMeans& out) {
    constexpr int kFewest = 16;
    const double duration_s = (end - begin).seconds();
    int samples = 0;
    bool is_whole = true;
    double sum = 0.0;
    Axes mean = Axes::Zero();
    const auto for_each = [&](const auto& take) {
        return buffer.for_each_step(begin, end, [&](const ImuSample& a, const ImuSample& b, const ImuStepQuality& q) {
            is_whole = is_whole && q.gap == Duration{} && q.clipped == 0;
            const double h = (b.stamp - a.stamp).seconds();
            const double phase =
                2.0 * std::numbers::pi * ((a.stamp - begin).seconds() + 0.5 * h) / duration_s;  // at the step's middle
            take(phase, h * (1.0 - std::cos(phase)), Axes(0.5 * (axes_of(a) + axes_of(b))));
        });
    };
    FACET_TRY(for_each([&](double, double weight, const Axes& x) {
        ++samples;
        sum += weight;
        mean += weight * x;
    }));
    if (samples < kFewest) {
        return Status::kNotReady;
    }
    if (!is_whole) {
        return Status::kDegenerate;
    }
    mean /= sum;
    std::array<Axes, 4> waves;
    waves.fill(Axes::Zero());
    FACET_TRY(for_each([&](double phase, double weight, const Axes& x) {
        const Axes rest = weight * (x - mean);
        waves[0] += std::cos(2.0 * phase) * rest;
        waves[1] += std::sin(2.0 * phase) * rest;
        waves[2] += std::cos(3.0 * phase) * rest;
        waves[3] += std::sin(3.0 * phase) * rest;
    }));
    Axes power = Axes::Zero();
    for (const Axes& wave : waves) {
        power += 0.5 * wave.square();
    }
    const Axes sigma = power.sqrt() / sum;
    out = {mean.head<3>(), mean.tail<3>(), sigma.head<3>(), sigma.tail<3>()};
    return Status::kOk;
}

}  // namespace facet
