// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/check/imu_checks.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/support/statistics.h"

namespace facet {
namespace {

constexpr double kRestLengthS = 1.0;
constexpr int kRestParts = 10;             // means over a tenth of it
constexpr double kRestGyro = 0.02;         // rad/s
constexpr double kRestAccel = 0.15;        // m/s^2
constexpr double kStandardGravity = 9.81;  // m/s^2
constexpr double kMetresPerG = 9.80665;    // m/s^2

double median_step_s(std::span<const ImuSample> samples) {
    std::vector<double> steps;
    for (std::size_t i = 1; i < samples.size(); ++i) {
        steps.push_back((samples[i].stamp - samples[i - 1].stamp).seconds());
    }
    return OrderStatistics(std::move(steps)).median();
}

/// Range of the means over the parts of a stretch, largest axis, of gyroscope and accelerometer.
std::pair<double, double> wander(std::span<const ImuSample> stretch) {
    Eigen::Array<double, 6, 1> least = Eigen::Array<double, 6, 1>::Constant(1e9);
    Eigen::Array<double, 6, 1> most = -least;
    const std::size_t length = stretch.size() / kRestParts;
    for (std::size_t part = 0; part < kRestParts; ++part) {
        Eigen::Array<double, 6, 1> mean = Eigen::Array<double, 6, 1>::Zero();
        for (const ImuSample& s : stretch.subspan(part * length, length)) {
            mean.head<3>() += s.w_B.array();
            mean.tail<3>() += s.a_B.array();
        }
        mean /= static_cast<double>(length);
        least = least.min(mean);
        most = most.max(mean);
    }
    const Eigen::Array<double, 6, 1> range = most - least;
    return {range.head<3>().maxCoeff(), range.tail<3>().maxCoeff()};
}

/// Root mean square of the differences of consecutive samples over all rests, over sqrt(2): gyroscope, accelerometer,
/// mean of the axes.
std::pair<double, double> white_noise(std::span<const ImuSample> samples, std::span<const RestStretch> rests) {
    double gyro = 0.0;
    double accel = 0.0;
    std::size_t count = 0;
    for (const RestStretch& rest : rests) {
        for (std::size_t i = rest.begin + 1; i < rest.end; ++i, ++count) {
            gyro += (samples[i].w_B - samples[i - 1].w_B).squaredNorm();
            accel += (samples[i].a_B - samples[i - 1].a_B).squaredNorm();
        }
    }
    const double n = 6.0 * static_cast<double>(std::max<std::size_t>(count, 1));
    return {std::sqrt(gyro / n), std::sqrt(accel / n)};
}

}  // namespace

std::vector<RestStretch> find_rests(std::span<const ImuSample> samples) {
    std::vector<RestStretch> rests;
    const double step_s = median_step_s(samples);
    if (!(step_s > 0.0)) {
        return rests;
    }
    const auto length = static_cast<std::size_t>(kRestLengthS / step_s);
    if (length < 2 * kRestParts) {
        return rests;
    }
    for (std::size_t begin = 0; begin + length <= samples.size(); begin += length) {
        const auto [gyro, accel] = wander(samples.subspan(begin, length));
        if (gyro < kRestGyro && accel < kRestAccel) {
            rests.push_back({begin, begin + length});
        }
    }
    return rests;
}

CheckVerdict check_imu_rate(std::span<const ImuSample> samples, const ImuNoise& noise) {
    CheckVerdict verdict{.name = "imu rate", .sentence = "there are no inertial samples.", .figures = {}};
    const double step_s = median_step_s(samples);
    if (!(step_s > 0.0)) {
        verdict.level = CheckLevel::kWrong;
        return verdict;
    }
    const double rate_hz = 1.0 / step_s;
    verdict.level = level_of(std::abs(rate_hz / noise.rate_hz - 1.0), 0.05, 0.3);
    verdict.sentence = fmt::format("samples come at {:.0f} Hz, the file says {:.0f} Hz.", rate_hz, noise.rate_hz);
    verdict.figures = {{"rate_hz", rate_hz}, {"file_rate_hz", noise.rate_hz}};
    return verdict;
}

CheckVerdict check_gravity(std::span<const ImuSample> samples, std::span<const RestStretch> rests) {
    CheckVerdict verdict{.name = "gravity", .sentence = "there are no inertial samples.", .figures = {}};
    if (samples.empty()) {
        return verdict;
    }
    double magnitude = 0.0;
    for (const RestStretch& rest : rests) {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (const ImuSample& s : samples.subspan(rest.begin, rest.end - rest.begin)) {
            sum += s.a_B;
        }
        magnitude += (sum / static_cast<double>(rest.end - rest.begin)).norm() / static_cast<double>(rests.size());
    }
    const bool rested = !rests.empty();
    for (const ImuSample& s : samples) {
        magnitude += rested ? 0.0 : s.a_B.norm() / static_cast<double>(samples.size());
    }
    const char* when = rested ? "at rest" : "on average in motion";
    verdict.figures = {{"magnitude_m_per_s2", magnitude}, {"at_rest", rested ? 1.0 : 0.0}};
    verdict.level = level_of(std::abs(magnitude - kStandardGravity), rested ? 0.3 : 0.6, rested ? 0.8 : 1.5);
    verdict.sentence = fmt::format("the accelerometer reads {:.2f} m/s^2 {}.", magnitude, when);
    if (std::abs(magnitude - 1.0) < 0.2) {
        verdict.level = CheckLevel::kWrong;
        verdict.sentence = fmt::format("the accelerometer reads {:.2f} {}: it is in g, multiply it by {}.", magnitude,
                                       when, kMetresPerG);
    } else if (magnitude < 0.5) {
        verdict.level = CheckLevel::kWrong;
        verdict.sentence = fmt::format(
            "the accelerometer reads {:.2f} m/s^2 {}: gravity has been taken out, but it is needed.", magnitude, when);
    }
    return verdict;
}

CheckVerdict check_imu_noise(std::span<const ImuSample> samples, std::span<const RestStretch> rests,
                             const ImuNoise& noise) {
    CheckVerdict verdict{.name = "imu noise",
                         .sentence = "the vehicle never rests for a second: noise and motion cannot be separated.",
                         .figures = {}};
    if (rests.empty()) {
        return verdict;
    }
    const auto [gyro, accel] = white_noise(samples, rests);
    const double root_s = std::sqrt(median_step_s(samples));
    const double gyro_ratio = gyro * root_s / noise.gyro_noise_rad_per_s_per_sqrt_hz;
    const double accel_ratio = accel * root_s / noise.accel_noise_m_per_s2_per_sqrt_hz;
    const double most = std::max(gyro_ratio, accel_ratio);
    verdict.level = level_of(most, 3.0, 10.0);
    verdict.sentence = fmt::format(
        "at rest ({:.0f} s) the gyroscope has {:.1f} times the file's white noise, the accelerometer {:.1f} times{}",
        kRestLengthS * static_cast<double>(rests.size()), gyro_ratio, accel_ratio,
        most > 3.0 ? ": raise the densities, or rotors were running." : ".");
    verdict.figures = {{"gyro_ratio", gyro_ratio}, {"accel_ratio", accel_ratio}};
    if (verdict.level == CheckLevel::kWrong) {
        verdict.level = CheckLevel::kSuspicious;  // rotors that run on the ground do the same
    }
    return verdict;
}

}  // namespace facet
