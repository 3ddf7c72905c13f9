// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/faults/rotor_vibration.h"

#include <cmath>
#include <numbers>

#include "app/support/rng.h"

namespace facet {
namespace {

constexpr double kLineStep_hz = 2.5;
constexpr double kFirstLine_hz = VibrationSpectrum::kEdges_hz.front() + 0.5 * kLineStep_hz;
constexpr double kNodeStep_s = 1.0 / kLineStep_hz;
constexpr std::uint64_t kRotorStream = 22;  // of the random numbers

constexpr VibrationSpectrum kSilence{};

constexpr VibrationSpectrum kIdling{
    .gyro = {{{0.0018, 0.0055, 0.0327, 0.0231, 0.0112, 0.0093, 0.0029, 0.0039, 0.0024, 0.0026, 0.0028, 0.0012},
              {0.0052, 0.0031, 0.0069, 0.0047, 0.0045, 0.0030, 0.0036, 0.0068, 0.0100, 0.0135, 0.0050, 0.0028},
              {0.0034, 0.0080, 0.0083, 0.0070, 0.0047, 0.0025, 0.0021, 0.0047, 0.0048, 0.0035, 0.0040, 0.0019}}},
    .accel = {{{0.039, 0.036, 0.071, 0.074, 0.074, 0.060, 0.063, 0.168, 0.195, 0.275, 0.122, 0.082},
               {0.023, 0.052, 0.375, 0.319, 0.200, 0.188, 0.062, 0.108, 0.057, 0.076, 0.065, 0.033},
               {0.050, 0.032, 0.045, 0.052, 0.052, 0.042, 0.041, 0.090, 0.074, 0.094, 0.073, 0.060}}}};

constexpr VibrationSpectrum kFlying{
    .gyro = {{{0.0057, 0.0090, 0.0072, 0.0094, 0.0160, 0.0078, 0.0032, 0.0025, 0.0014, 0.0018, 0.0038, 0.0035},
              {0.0108, 0.0233, 0.0235, 0.0101, 0.0034, 0.0026, 0.0021, 0.0055, 0.0055, 0.0090, 0.0237, 0.0219},
              {0.0144, 0.0227, 0.0164, 0.0148, 0.0098, 0.0044, 0.0021, 0.0043, 0.0029, 0.0055, 0.0140, 0.0133}}},
    .accel = {{{0.084, 0.216, 0.267, 0.179, 0.130, 0.126, 0.119, 0.261, 0.198, 0.268, 0.557, 0.532},
               {0.027, 0.057, 0.072, 0.125, 0.275, 0.154, 0.083, 0.123, 0.112, 0.162, 0.181, 0.149},
               {0.053, 0.107, 0.126, 0.127, 0.115, 0.131, 0.109, 0.245, 0.187, 0.204, 0.322, 0.334}}}};

}  // namespace

const VibrationSpectrum& vibration_spectrum(VibrationKind kind) {
    switch (kind) {
        case VibrationKind::kNone: break;
        case VibrationKind::kIdle: return kIdling;
        case VibrationKind::kFlight: return kFlying;
    }
    return kSilence;
}

RotorVibration::RotorVibration(const VibrationSpectrum& spectrum, std::uint64_t seed) : seed_(seed) {
    std::size_t band = 0;
    for (int j = 0; j < kLines; ++j) {
        const double f_hz = kFirstLine_hz + j * kLineStep_hz;
        while (f_hz > VibrationSpectrum::kEdges_hz.at(band + 1)) {
            ++band;
        }
        const double width_hz = VibrationSpectrum::kEdges_hz.at(band + 1) - VibrationSpectrum::kEdges_hz.at(band);
        const double share = std::sqrt(kLineStep_hz / width_hz);  // the band's power, in equal parts
        for (std::size_t axis = 0; axis < 3; ++axis) {
            sigmas_(static_cast<int>(axis), j) = share * spectrum.gyro[axis][band];
            sigmas_(static_cast<int>(axis) + 3, j) = share * spectrum.accel[axis][band];
        }
    }
}

void RotorVibration::draw(std::int64_t node, Amplitudes& amplitudes) const {
    RandomStream random(hash64(seed_, static_cast<std::uint64_t>(node)), kRotorStream);
    for (int j = 0; j < kLines; ++j) {
        for (int axis = 0; axis < 6; ++axis) {
            amplitudes(axis, 2 * j) = sigmas_(axis, j) * random.normal();
            amplitudes(axis, 2 * j + 1) = sigmas_(axis, j) * random.normal();
        }
    }
}

RotorVibration::Vector6 RotorVibration::at(double t_s) {
    const double place = t_s / kNodeStep_s;
    const auto node = static_cast<std::int64_t>(place);
    if (node != node_) {
        if (node == node_ + 1 && node_ >= 0) {
            before_ = after_;
        } else {
            draw(node, before_);
        }
        draw(node + 1, after_);
        node_ = node;
    }
    Eigen::Matrix<double, 2 * kLines, 1> waves;
    for (int j = 0; j < kLines; ++j) {
        const double cycles = (kFirstLine_hz + j * kLineStep_hz) * t_s;
        const double angle = 2.0 * std::numbers::pi * (cycles - std::floor(cycles));
        waves(2 * j) = std::cos(angle);
        waves(2 * j + 1) = std::sin(angle);
    }
    const double turn = 0.5 * std::numbers::pi * (place - static_cast<double>(node));
    return std::cos(turn) * (before_ * waves) + std::sin(turn) * (after_ * waves);
}

}  // namespace facet
