// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/time_shift.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "app/lab/eval/alignment.h"
#include "app/lab/eval/pose_difference.h"
#include "estimator/geometry/so3.h"

namespace facet {
namespace {

constexpr std::size_t kLeastPoses = 10;
constexpr double kLongestStep_s = 0.25;
constexpr double kLeastPath_m = 1.0;

/// Errors that are linear in [shift, a, b].
class Fit {
public:
    using Row = Eigen::Matrix<double, 3, 7>;

    void add(const Row& row, const Eigen::Vector3d& error) {
        h_ += row.transpose() * row;
        g_ += row.transpose() * error;
        squares_ += error.squaredNorm();
        ++count_;
    }

    std::size_t count() const { return count_; }

    double shift() const { return solution()(0); }

    /// Root mean square of what the solution leaves.
    double left() const {
        return std::sqrt(std::max(0.0, squares_ - g_.dot(solution())) / static_cast<double>(count_));
    }

private:
    using Vector = Eigen::Matrix<double, 7, 1>;

    Vector solution() const {
        // A vehicle that never turns leaves some of it open: the shortest of all solutions, nearly.
        const Eigen::Matrix<double, 7, 7> damped =
            h_ + 1e-9 * h_.diagonal().maxCoeff() * Eigen::Matrix<double, 7, 7>::Identity();
        return damped.ldlt().solve(g_);
    }

    Eigen::Matrix<double, 7, 7> h_ = Eigen::Matrix<double, 7, 7>::Zero();
    Vector g_ = Vector::Zero();
    double squares_ = 0.0;
    std::size_t count_ = 0;
};

Fit::Row row_of(const Eigen::Vector3d& rate, const Eigen::Matrix3d& d_error_d_a) {
    Fit::Row row;
    row << rate, d_error_d_a, Eigen::Matrix3d::Identity();
    return row;
}

}  // namespace

TimeShift time_shift(std::span<const PosePair> pairs) {
    const Se3 T_true_est = align(pairs, AlignmentMode::kSe3);
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const PosePair& pair : pairs) {
        middle += pair.truth.p / static_cast<double>(pairs.size());
    }
    Fit positions;
    Fit orientations;
    double path_m = 0.0;
    for (std::size_t i = 1; i + 1 < pairs.size(); ++i) {
        const double dt_s = (pairs[i + 1].stamp - pairs[i - 1].stamp).seconds();
        if (!(dt_s > 0.0 && dt_s < kLongestStep_s)) {
            continue;
        }
        const Se3& truth = pairs[i].truth;
        const PoseDifference step = pose_difference(pairs[i - 1].truth, pairs[i + 1].truth);
        const PoseDifference error = pose_difference(truth, T_true_est * pairs[i].estimate);
        positions.add(row_of(step.p / dt_s, -skew(truth.p - middle)), error.p);
        orientations.add(row_of(step.theta / dt_s, truth.q.toRotationMatrix().transpose()), error.theta);
        path_m += 0.5 * step.distance_m();
    }
    TimeShift shift;
    if (positions.count() >= kLeastPoses && path_m >= kLeastPath_m) {
        shift.is_known = true;
        shift.position_s = positions.shift();
        shift.position_rmse_m = positions.left();
        shift.orientation_s = orientations.shift();
    }
    return shift;
}

}  // namespace facet
