// SPDX-License-Identifier: BSD-2-Clause
// The model of rotors: its strength in each band and on each axis, as stated; that it is broad, and never repeats.
#include "app/lab/faults/rotor_vibration.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

namespace facet::rotor_vibration_test {
namespace {

constexpr double kRate_hz = 200.0;

/// [w a] at 200 Hz.
std::vector<RotorVibration::Vector6> shaken(VibrationKind kind, std::uint64_t seed, double seconds) {
    RotorVibration rotors(vibration_spectrum(kind), seed);
    std::vector<RotorVibration::Vector6> samples;
    for (int k = 0; k < static_cast<int>(seconds * kRate_hz); ++k) {
        samples.push_back(rotors.at(k / kRate_hz));
    }
    return samples;
}

double rms(const std::vector<RotorVibration::Vector6>& samples, int axis) {
    double sum = 0.0;
    for (const RotorVibration::Vector6& x : samples) {
        sum += x[axis] * x[axis];
    }
    return std::sqrt(sum / static_cast<double>(samples.size()));
}

/// Mean square at the frequencies k / T in [low, high).
double band_power(const std::vector<RotorVibration::Vector6>& samples, int axis, double low_hz, double high_hz) {
    const auto count = static_cast<double>(samples.size());
    const double step_hz = kRate_hz / count;
    double sum = 0.0;
    for (auto k = static_cast<int>(std::ceil(low_hz / step_hz)); k * step_hz < high_hz; ++k) {
        const std::complex<double> turn = std::polar(1.0, -2.0 * std::numbers::pi * k / count);
        std::complex<double> phase = 1.0;
        std::complex<double> amplitude = 0.0;
        for (const RotorVibration::Vector6& x : samples) {
            amplitude += x[axis] * phase;
            phase *= turn;
        }
        sum += 2.0 * std::norm(amplitude / count);
    }
    return sum;
}

TEST_CASE("Rotors shake as strongly as measured, on each axis") {
    // rms of the two records: gyroscope x y z (rad/s), accelerometer x y z (m/s^2)
    const struct {
        VibrationKind kind;
        std::array<double, 6> rms;
    } records[] = {{VibrationKind::kIdle, {0.0435, 0.0227, 0.0174, 0.436, 0.592, 0.214}},
                   {VibrationKind::kFlight, {0.0248, 0.0502, 0.0420, 0.988, 0.490, 0.663}}};
    for (const auto& record : records) {
        const auto samples = shaken(record.kind, 1, 60.0);
        for (std::size_t axis = 0; axis < 6; ++axis) {
            CHECK(rms(samples, static_cast<int>(axis)) == Approx(record.rms.at(axis)).epsilon(0.05));
        }
    }
    CHECK(rms(shaken(VibrationKind::kNone, 1, 1.0), 3) == 0.0);
}

TEST_CASE("Rotors have the measured power in each band, and next to none below all bands") {
    for (const VibrationKind kind : {VibrationKind::kIdle, VibrationKind::kFlight}) {
        const VibrationSpectrum& spectrum = vibration_spectrum(kind);
        const auto samples = shaken(kind, 3, 30.0);
        for (const int axis : {0, 1, 3, 5}) {
            const auto& bands = axis < 3 ? spectrum.gyro.at(static_cast<std::size_t>(axis))
                                         : spectrum.accel.at(static_cast<std::size_t>(axis - 3));
            const double all = std::pow(rms(samples, axis), 2);
            for (std::size_t band = 0; band < VibrationSpectrum::kBands; ++band) {
                const double low_hz = VibrationSpectrum::kEdges_hz.at(band);
                const double high_hz = VibrationSpectrum::kEdges_hz.at(band + 1);
                const double stated = bands.at(band) * bands.at(band);
                INFO("axis " << axis << ", " << low_hz << " to " << high_hz << " Hz");
                // Each band takes a little of its neighbours'.
                CHECK(std::abs(band_power(samples, axis, low_hz, high_hz) - stated) < 0.25 * stated + 0.03 * all);
            }
            CHECK(band_power(samples, axis, 0.0, 3.0) < 0.02 * all);
        }
    }
}

TEST_CASE("Rotors never repeat, are the same for the same seed, and can be had in any order") {
    const auto samples = shaken(VibrationKind::kFlight, 1, 60.0);
    double square = 0.0;
    for (const int lag_s : {1, 2, 4, 8, 20}) {
        double product = 0.0;
        square = 0.0;
        const auto lag = static_cast<std::size_t>(lag_s * kRate_hz);
        for (std::size_t k = 0; k + lag < samples.size(); ++k) {
            product += samples[k][3] * samples[k + lag][3];
            square += samples[k][3] * samples[k][3];
        }
        CHECK(std::abs(product) < 0.1 * square);
    }
    RotorVibration again(vibration_spectrum(VibrationKind::kFlight), 1);
    for (const std::size_t k : {11'999U, 0U, 700U, 701U, 80U, 79U}) {
        CHECK(again.at(static_cast<double>(k) / kRate_hz) == samples[k]);
    }
    RotorVibration other(vibration_spectrum(VibrationKind::kFlight), 2);
    CHECK(other.at(3.5) != samples[700]);
}

}  // namespace
}  // namespace facet::rotor_vibration_test
