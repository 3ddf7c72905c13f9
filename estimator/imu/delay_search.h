// SPDX-License-Identifier: BSD-2-Clause
// Finds how late image stamps are by how the camera and the gyroscope turn.
#pragma once

#include <Eigen/Core>
#include <boost/container/static_vector.hpp>
#include <span>

#include "estimator/imu/imu_buffer.h"
#include "platform/base/status.h"
#include "platform/base/timestamp.h"

namespace facet {

/// Image stamps plus `value_s` are the IMU's time.
struct ImageDelay {
    double value_s = 0.0;
    double sigma_s = 0.0;
};

/// Compares turns from image to image, which are known without the gyroscope, with the gyroscope's over the same times
/// shifted by d: the least sum of |turn_i - int_{t0_i + d}^{t1_i + d} w dt + b (t1_i - t0_i)|^2, with b the bias for
/// each d in closed form, over d within kRange_s, a parabola through the least of a grid and its neighbours. Turns
/// between images are so small that their vectors add up. No heap. Thread-bound.
class DelaySearch {
public:
    static constexpr double kRange_s = 0.08;
    static constexpr std::size_t kCapacity = 192;  ///< turns, the newest ones, of kSpan_s at most
    static constexpr double kSpan_s = 3.2;

    void reset();
    /// A turn between two images that follow each other (stamps of the images, rad, axes of the body). One that does
    /// not begin where the last one ended begins a new series.
    void add(Timestamp begin, Timestamp end, const Eigen::Vector3d& turn_B);
    std::size_t size() const { return turns_.size(); }
    /// There may be turns enough for solve().
    bool is_ready() const { return turns_.size() >= kFewestTurns; }

    /// @param found  written on kOk
    /// @return kNotReady if the turns are too few or too steady to give the delay to kMostSigma_s, or the samples do
    ///         not cover them; kDegenerate if no delay within the range explains them
    Status solve(const ImuBuffer& imu, ImageDelay& found);

private:
    static constexpr int kSteps = 16;  ///< of the grid, either way
    static constexpr double kMostSigma_s = 4e-3;
    static constexpr std::size_t kFewestTurns = 20;

    struct Turn {
        Timestamp begin;
        Timestamp end;
        Eigen::Vector3d turn_B = Eigen::Vector3d::Zero();
    };
    using Turns = std::span<const Turn>;

    /// Integral of the rate since the first turn's earliest begin, at increasing times.
    struct Angle {
        Timestamp stamp;
        Eigen::Vector3d value = Eigen::Vector3d::Zero();
    };
    static constexpr double kAngleSpacing_s = 9e-4;  ///< samples may come at 1 kHz
    using Angles =
        boost::container::static_vector<Angle,
                                        static_cast<std::size_t>((kSpan_s + 2.0 * kRange_s) / kAngleSpacing_s) + 32>;
    /// kNotReady if samples are missing or clipped; else as ImuBuffer::for_each_step.
    static Status integrate(const ImuBuffer& imu, Timestamp begin, Timestamp end, Angles& out);
    /// Sum of the squared differences of the turns from their mean.
    static double spread(Turns turns);
    static double misfit(Turns turns, const Angles& angles, double delay_s);
    static Eigen::Vector3d at(const Angles& angles, Timestamp t);

    boost::container::static_vector<Turn, kCapacity> turns_;
    Angles angles_;  ///< of the search at hand
};

}  // namespace facet
