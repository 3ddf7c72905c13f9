// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/truth_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "app/lab/eval/alignment.h"
#include "app/lab/eval/pose_difference.h"
#include "estimator/geometry/so3.h"

namespace facet {
namespace {

constexpr std::size_t kLeastPoses = 30;
constexpr double kLongestStep_s = 0.25;
constexpr double kLeastPath_m = 1.0;
constexpr Duration kLongestHole = Duration::from_seconds(0.5);
// Priors as wide as anybody's set-up, so that what a flight does not show stays near zero.
constexpr double kLagPrior_s = 1.0;
constexpr double kLeverArmPrior_m = 1.0;
constexpr double kScalePrior = 1.0;
constexpr double kTurnPrior_rad = 1.0;
constexpr double kAlignmentPrior = 10.0;
constexpr double kSwift_s = 0.5;          // to either side
constexpr double kLeastVariance = 1e-14;  // of errors that are exact

/// Least squares with rows of three errors that follow each other in time.
template <int kSize>
class LinearFit {
public:
    using Row = Eigen::Matrix<double, 3, kSize>;
    using Vector = Eigen::Matrix<double, kSize, 1>;

    void add(const Row& row, const Eigen::Vector3d& error) {
        rows_.push_back(row);
        errors_.push_back(error);
    }

    std::size_t count() const { return rows_.size(); }

    /// Twice: once to know how large the errors are that are left, then with the prior's due weight beside them.
    void solve(const Vector& prior_sigmas) {
        Normal h = Normal::Zero();
        Vector g = Vector::Zero();
        for (std::size_t i = 0; i < rows_.size(); ++i) {
            h += rows_[i].transpose() * rows_[i];
            g += rows_[i].transpose() * errors_[i];
        }
        const Vector prior = prior_sigmas.cwiseAbs2().cwiseInverse();
        const auto n = static_cast<double>(count());
        double variance = 1e-6 / n;  // so that the prior hardly counts at first
        for (int pass = 0; pass < 2; ++pass) {
            Normal information = h / variance;
            information.diagonal() += prior;
            const Eigen::LDLT<Normal> ldlt(information);
            x_ = ldlt.solve(g / variance);
            sigma_ = ldlt.solve(Normal::Identity()).diagonal().cwiseMax(0.0).cwiseSqrt();
            std::vector<Eigen::Vector3d> left = errors_;
            double squares = 0.0;
            for (std::size_t i = 0; i < rows_.size(); ++i) {
                left[i] -= rows_[i] * x_;
                squares += left[i].squaredNorm();
            }
            rmse_ = std::sqrt(squares / n);
            left_ = left;
            variance = std::max(kLeastVariance, squares / (3.0 * n - kSize) * autocorrelation_time(left, squares));
        }
    }

    Fitted number(int at) const { return {x_(at), sigma_(at)}; }
    FittedVector vector(int at) const { return {x_.template segment<3>(at), sigma_.template segment<3>(at)}; }
    double rmse() const { return rmse_; }
    /// Of what is left beyond its own running mean over so many rows to either side.
    double swift_rmse(std::size_t reach) const {
        double squares = 0.0;
        for (std::size_t i = 0; i < left_.size(); ++i) {
            const std::size_t first = i > reach ? i - reach : 0;
            const std::size_t end = std::min(left_.size(), i + reach + 1);
            Eigen::Vector3d sum = Eigen::Vector3d::Zero();
            for (std::size_t k = first; k < end; ++k) {
                sum += left_[k];
            }
            squares += (left_[i] - sum / static_cast<double>(end - first)).squaredNorm();
        }
        return std::sqrt(squares / static_cast<double>(count()));
    }

private:
    using Normal = Eigen::Matrix<double, kSize, kSize>;

    /// 1 + 2 sum rho(k) over lags k up to the first one without correlation, in rows.
    static double autocorrelation_time(const std::vector<Eigen::Vector3d>& left, double squares) {
        double time = 1.0;
        for (std::size_t lag = 1; lag < left.size() / 2 && squares > 0.0; ++lag) {
            double products = 0.0;
            for (std::size_t i = lag; i < left.size(); ++i) {
                products += left[i].dot(left[i - lag]);
            }
            if (products <= 0.0) {
                break;
            }
            time += 2.0 * products / squares;
        }
        return time;
    }

    std::vector<Row> rows_;
    std::vector<Eigen::Vector3d> errors_;
    std::vector<Eigen::Vector3d> left_;
    Vector x_ = Vector::Zero();
    Vector sigma_ = Vector::Zero();
    double rmse_ = 0.0;
};

// Positions: lag, lever arm, scale, d, e.
constexpr int kLeverArmAt = 1;
constexpr int kScaleAt = 4;
constexpr int kPositionUnknowns = 11;
// Orientations: lag, turn, f.
constexpr int kTurnAt = 1;
constexpr int kOrientationUnknowns = 7;

using PositionFit = LinearFit<kPositionUnknowns>;
using OrientationFit = LinearFit<kOrientationUnknowns>;

PositionFit::Row position_row(const Eigen::Vector3d& velocity, const Eigen::Matrix3d& R,
                              const Eigen::Vector3d& from_centre) {
    PositionFit::Row row;
    row << velocity, R, -from_centre, -skew(from_centre), Eigen::Matrix3d::Identity();
    return row;
}

PositionFit::Vector position_priors() {
    PositionFit::Vector priors = PositionFit::Vector::Constant(kAlignmentPrior);
    priors(0) = kLagPrior_s;
    priors.segment<3>(kLeverArmAt).setConstant(kLeverArmPrior_m);
    priors(kScaleAt) = kScalePrior;
    return priors;
}

OrientationFit::Vector orientation_priors() {
    OrientationFit::Vector priors = OrientationFit::Vector::Constant(kAlignmentPrior);
    priors(0) = kLagPrior_s;
    priors.segment<3>(kTurnAt).setConstant(kTurnPrior_rad);
    return priors;
}

}  // namespace

TruthFit fit_truth(std::span<const PosePair> pairs) {
    const Se3 T_true_est = align(pairs, AlignmentMode::kSe3);
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (const PosePair& pair : pairs) {
        centre += pair.truth.p / static_cast<double>(pairs.size());
    }
    PositionFit positions;
    OrientationFit orientations;
    double path_m = 0.0;
    for (std::size_t i = 1; i + 1 < pairs.size(); ++i) {
        const double dt_s = (pairs[i + 1].stamp - pairs[i - 1].stamp).seconds();
        if (!(dt_s > 0.0 && dt_s < kLongestStep_s)) {
            continue;
        }
        const Se3& truth = pairs[i].truth;
        const Eigen::Matrix3d R = truth.q.toRotationMatrix();
        const PoseDifference step = pose_difference(pairs[i - 1].truth, pairs[i + 1].truth);
        const PoseDifference error = pose_difference(truth, T_true_est * pairs[i].estimate);
        positions.add(position_row(step.p / dt_s, R, truth.p - centre), error.p);
        OrientationFit::Row row;
        row << step.theta / dt_s, Eigen::Matrix3d::Identity(), R.transpose();
        orientations.add(row, error.theta);
        path_m += 0.5 * step.distance_m();
    }
    TruthFit fit;
    if (positions.count() < kLeastPoses || path_m < kLeastPath_m) {
        return fit;
    }
    positions.solve(position_priors());
    orientations.solve(orientation_priors());
    fit.is_known = true;
    fit.lag_s = positions.number(0);
    fit.lever_arm_m = positions.vector(kLeverArmAt);
    fit.scale = positions.number(kScaleAt);
    fit.scale.value += 1.0;
    fit.orientation_lag_s = orientations.number(0);
    fit.turn_rad = orientations.vector(kTurnAt);
    fit.position_rmse_m = positions.rmse();
    fit.orientation_rmse_rad = orientations.rmse();
    const double rate_hz = static_cast<double>(pairs.size() - 1) / (pairs.back().stamp - pairs.front().stamp).seconds();
    const auto reach = static_cast<std::size_t>(std::lround(kSwift_s * rate_hz));
    fit.position_swift_rmse_m = positions.swift_rmse(reach);
    fit.orientation_swift_rmse_rad = orientations.swift_rmse(reach);
    return fit;
}

std::vector<GroundTruthState> with_fit(std::span<const GroundTruthState> truth, const TruthFit& fit) {
    const Duration late = Duration::from_seconds(fit.lag_s.shown());
    const Duration turned_late = Duration::from_seconds(fit.orientation_lag_s.shown());
    const Duration half_step = Duration::from_seconds(0.01);
    const Eigen::Quaterniond turn = so3_exp(fit.turn_rad.shown());
    const Eigen::Vector3d lever_arm_m = fit.lever_arm_m.shown();
    std::vector<GroundTruthState> result;
    for (GroundTruthState state : truth) {
        const std::optional<GroundTruthState> place = interpolate(truth, state.stamp + late, kLongestHole);
        const std::optional<GroundTruthState> attitude = interpolate(truth, state.stamp + turned_late, kLongestHole);
        const auto before = interpolate(truth, state.stamp + turned_late - half_step, kLongestHole);
        const auto after = interpolate(truth, state.stamp + turned_late + half_step, kLongestHole);
        if (!place || !attitude || !before || !after) {
            continue;
        }
        const Eigen::Vector3d rate =
            so3_log((before->q_W_B.conjugate() * after->q_W_B).normalized()) / (2.0 * half_step.seconds());
        state.p_W_B = place->p_W_B + attitude->q_W_B * lever_arm_m;
        state.v_W_B = place->v_W_B + attitude->q_W_B * rate.cross(lever_arm_m);
        state.q_W_B = (attitude->q_W_B * turn).normalized();
        result.push_back(state);
    }
    return result;
}

}  // namespace facet
