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

/// What turns say of a delay, beside the one that is believed.
struct DelayFit {
    ImageDelay delay;     ///< that explains them best
    double gain = 0.0;    ///< by it over the one believed: chi-square of one degree of freedom
    double misfit = 0.0;  ///< of the one believed: mean square of the differences over the variance expected
};

/// Compares turns from image to image, which are known without the gyroscope, with the gyroscope's over the same times
/// shifted by d: the least sum of |turn_i - int_{t0_i + d}^{t1_i + d} w dt + b (t1_i - t0_i)|^2, with b the bias for
/// each d in closed form, over d within kRange_s. Each d is compared with the delay believed over the turns for which
/// there are samples; a parabola goes through the best of a grid and its neighbours. Turns between images are so small
/// that their vectors add up. No heap. Thread-bound.
class DelaySearch {
public:
    static constexpr double kRange_s = 0.08;
    static constexpr std::size_t kCapacity = 192;  ///< turns, the newest ones, of kSpan_s at most
    static constexpr double kSpan_s = 3.2;

    static constexpr std::size_t kManyTurns = 20;  ///< which show how much they scatter

    /// Forgets all turns. @param sigma_rad  of a turn as images show it
    void configure(double sigma_rad) {
        reset();
        sigma_rad_ = sigma_rad;
    }
    void reset() { turns_.clear(); }
    /// A turn between two images (stamps of the images, rad, axes of the body). It may overlap the last one, if it is
    /// of other tracks; one that begins after the end of that begins a new series.
    void add(Timestamp begin, Timestamp end, const Eigen::Vector3d& turn_B);
    std::size_t size() const { return turns_.size(); }

    /// @param believed_s  delay to compare with (s), within kRange_s
    /// @param fit         zero but for what the turns show
    /// @return kOk: they show `delay` to kMostSigma_s. kNotReady: they are too few or too steady for that, or there are
    ///         not the samples; kDegenerate: no delay within the range explains them. Then it is a guess at best.
    Status solve(const ImuBuffer& imu, double believed_s, DelayFit& fit);

private:
    static constexpr int kSteps = 16;  ///< of the grid, either way
    static constexpr double kMostSigma_s = 4e-3;
    static constexpr std::size_t kFewestTurns = 3;  ///< two give the bias of each axis, and hardly more

    struct Turn {
        Timestamp begin;
        Timestamp end;
        Eigen::Vector3d turn_B = Eigen::Vector3d::Zero();
    };
    using Turns = std::span<const Turn>;

    /// Integral of the rate since the earliest begin, at increasing times.
    struct Angle {
        Timestamp stamp;
        Eigen::Vector3d value = Eigen::Vector3d::Zero();
    };
    static constexpr double kAngleSpacing_s = 9e-4;  ///< samples may come at 1 kHz
    using Angles =
        boost::container::static_vector<Angle,
                                        static_cast<std::size_t>((kSpan_s + 2.0 * kRange_s) / kAngleSpacing_s) + 32>;
    /// Writes angles_ and shake_rad2_. kNotReady if samples are missing or clipped; else as ImuBuffer::for_each_step.
    Status integrate(const ImuBuffer& imu, Timestamp begin, Timestamp end);
    /// Turns for which there are samples whichever of these delays is right.
    Turns covered(double least_s, double most_s) const;
    /// The same for a delay of the grid, its neighbours and the one believed.
    Turns covered_at(int step, double believed_s) const;
    double misfit(Turns turns, double delay_s) const;
    /// Of a turn beforehand, and if the squared misfits with a delay add up to this.
    double expected_rad2() const { return sigma_rad_ * sigma_rad_ + shake_rad2_; }
    double variance(Turns turns, double squares) const;
    /// Misfits of a delay of the grid and of its neighbours, over the same turns.
    struct Parabola {
        int step = kSteps;  ///< kSteps either way: none can be given
        Turns turns;
        double before = 0.0;
        double least = 0.0;
        double after = 0.0;
    };
    int best_step(double believed_s) const;
    Parabola parabola(double believed_s) const;
    Eigen::Vector3d angle_at(Timestamp t) const;
    /// Sum of the squared differences of the turns from their mean.
    static double spread(Turns turns);

    double sigma_rad_ = 0.0;
    boost::container::static_vector<Turn, kCapacity> turns_;
    Angles angles_;            ///< of the search at hand
    double shake_rad2_ = 0.0;  ///< of a turn, what vibration adds to the gyroscope's
};

}  // namespace facet
