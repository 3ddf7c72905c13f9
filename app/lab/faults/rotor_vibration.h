// SPDX-License-Identifier: BSD-2-Clause
// What the rotors of a real multicopter add to inertial samples.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace facet {

enum class VibrationKind : std::uint8_t {
    kNone,
    kIdle,    ///< standing on the floor with idling rotors
    kFlight,  ///< in the air
};
inline constexpr std::array<const char*, 3> kVibrationNames{"none", "idle", "flight"};

/// Strength of the vibration in each of kBands bands of frequency, for each axis.
struct VibrationSpectrum {
    static constexpr std::size_t kBands = 12;
    /// Limits of the bands (Hz).
    static constexpr std::array<double, kBands + 1> kEdges_hz{5, 10, 15, 20, 25, 30, 35, 40, 60, 70, 80, 90, 100};
    using Bands = std::array<double, kBands>;

    std::array<Bands, 3> gyro;   ///< rms in each band about x, y, z of the IMU (rad/s)
    std::array<Bands, 3> accel;  ///< along x, y, z (m/s^2)
};

/// Measured spectra, as an ADIS16448 saw them at 200 Hz on the vehicle of the EuRoC sequences (Burri et al., "The EuRoC
/// micro aerial vehicle datasets", IJRR 2016): 4.5 s of idling at the beginning of V1_01_easy, a surge of the motors
/// included, above 5 Hz; 30 s of MH_05_difficult in flight, above 8 Hz. x of that IMU points up and z forward. What
/// lies above 100 Hz has been folded below, as it is for any IMU read at 200 Hz without a filter. kNone: all zero.
const VibrationSpectrum& vibration_spectrum(VibrationKind kind);

/// A stationary Gaussian process with such a spectrum, independent on all axes: a sum of lines 2.5 Hz apart,
///   x(t) = sum_j A_j(t) cos(w_j t) + B_j(t) sin(w_j t),
/// whose amplitudes go from one independent normal number to the next every 0.4 s as cos and sin of a quarter turn do,
/// which keeps the variance. It never repeats and can be had at any time. Deterministic in the seed. Thread-bound; heap
/// in the constructor only.
class RotorVibration {
public:
    using Vector6 = Eigen::Matrix<double, 6, 1>;

    RotorVibration(const VibrationSpectrum& spectrum, std::uint64_t seed);

    /// [w a] at this time (rad/s, m/s^2); fast for times in order.
    /// @param t_s  not negative, below 1e9
    Vector6 at(double t_s);

private:
    static constexpr int kLines = 38;
    using Amplitudes = Eigen::Matrix<double, 6, 2 * kLines>;  ///< a cosine and a sine for each line

    void draw(std::int64_t node, Amplitudes& amplitudes) const;

    Eigen::Matrix<double, 6, kLines> sigmas_;  ///< of each line's amplitudes
    std::uint64_t seed_;
    std::int64_t node_ = -1;  ///< whose amplitudes before_ has
    Amplitudes before_;
    Amplitudes after_;
};

}  // namespace facet
