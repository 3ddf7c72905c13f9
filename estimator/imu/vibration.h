// SPDX-License-Identifier: BSD-2-Clause
// How strongly the IMU vibrates above the band of motion, and the effect on integrals of its samples.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <numbers>

#include "platform/base/samples.h"

namespace facet {

/// Measured by a VibrationMeter, axes [w a]: variances of single samples in its two bands, (rad/s)^2 and (m/s^2)^2.
struct VibrationLevel {
    using Axes = Eigen::Array<float, 6, 1>;

    Axes high = Axes::Zero();
    Axes mid = Axes::Zero();

    Axes white() const { return high.min(mid); }            ///< of noise alike in both bands
    Axes tone() const { return (high - mid).max(0.0F); }    ///< of what is in the high band only
    Axes rumble() const { return (mid - high).max(0.0F); }  ///< of what is in the mid band only
};

/// Running power of the samples in two bands, given as shares of the sampling rate r (in brackets: Hz at 200 Hz), by
/// filters normalised so that white noise gives the variance of one sample in each:
///   high, 0.3 to 0.5 (60 to 100): fourth difference, |H|^2 = 256 sin^8(pi f/r) / 70
///   mid, 0.07 to 0.25 (15 to 50): second difference over two samples after [1 4 6 4 1] / 16,
///                                 |H|^2 = 16 cos^8(pi f/r) sin^4(2 pi f/r) / 0.77
/// squared and averaged exponentially over 0.25 s.
///
/// Effect on an integral. A sum of samples over T is wrong by the part of the folded spectrum within 1/T of zero, where
/// motion hides it. Noise that is white after folding (the sensor's, broad-band vibration) has the same density there
/// as in both bands, so the lesser band bounds it: `white`, a density of white / r. A tone or a narrow band in one band
/// only (a propeller) does not accumulate: a tone A cos(w t + c), whose phase at both ends of the interval is
/// arbitrary, leaves, with the trapezoidal rule, the error A g sin(w t + c) taken between the ends,
///   g = | (h/2) cot(w h / 2) - 1/w |,  h = 1/r,
/// an independent error at either end: no growth with T, a hundredth of the effect of white noise of its power over
/// 0.2 s. Over 80 to 120 Hz at 200 Hz (above 100 Hz the tone folds back) g^2 is 0.06 to 0.18 h^2 per power of the tone,
/// which the high band shows amplified by 2.4 to 3.7: 0.023 to 0.075 h^2 per power shown. edge_variances() takes
/// kEdge = 0.04 h^2.
/// How much of `white` accumulates is learnt (vibration_share.h): a share s of 1 if the spectrum is flat down to zero.
/// What is left where it falls off below the mid band, at f = 0.07 r, is as with a tone an error at either end,
///   variance = integral over f of S / (2 pi f)^2 = white h^2 / (2 pi^2 0.07),
/// of which edge_variances() takes the part 1 - s. Likewise `rumble`, what the mid band has more than the high one, as
/// rotors have below their blades' passage: the same integral over that band, S = rumble h. It is the ripple of the
/// sensor's attitude or velocity, which neither the body's motion nor images show. Tones of 20 to 40 Hz are right
/// within a factor of three; what lies below the band, where motion would be taken for vibration, is not seen.
/// Tones between 0.2 r and 0.3 r pass both filters a little and are overrated as white; rectification by the sensor
/// (coning, sculling, g-sensitivity) acts like a bias and is not modelled.
///
/// The level is a function of the samples since clear() only. Thread-bound. No heap.
class VibrationMeter {
public:
    static constexpr double kEdge = 0.04;
    static constexpr double kWhiteEdge = 1.0 / (2.0 * std::numbers::pi * std::numbers::pi * 0.07);
    static constexpr double kRumbleEdge = (1.0 / 0.07 - 1.0 / 0.25) / (2.0 * std::numbers::pi * std::numbers::pi);

    explicit VibrationMeter(double rate_hz = 200.0) { clear(rate_hz); }

    /// Forgets everything. @param rate_hz  of the samples, > 0
    void clear(double rate_hz);
    /// Forgets the last samples, because the next one does not follow them in time; the level stays.
    void restart() { filled_ = 0; }
    /// Takes in the sample one period after the last one.
    void add(const ImuSample& sample);

    const VibrationLevel& level() const { return level_; }

    /// Variances of an integral's error at either end of an interval, (rad)^2 or (m/s)^2.
    /// @param first_axis  of three: 0, the gyroscope's, or 3, the accelerometer's
    /// @param share       of `white` that accumulates
    static Eigen::Vector3d edge_variances(const VibrationLevel& level, int first_axis, double share, double rate_hz);

private:
    static constexpr int kTaps = 9;
    using Axes = Eigen::Array<double, 6, 1>;

    std::array<Axes, kTaps> last_{};  ///< newest first
    int filled_ = 0;
    double share_ = 0.0;  ///< of a new square in its average
    double count_ = 0.0;  ///< squares so far
    Axes high_ = Axes::Zero();
    Axes mid_ = Axes::Zero();
    VibrationLevel level_;
};

}  // namespace facet
