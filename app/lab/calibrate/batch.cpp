// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/calibrate/batch.h"

#include <ceres/ceres.h>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "app/lab/calibrate/batch_costs.h"
#include "app/lab/calibrate/batch_inertial.h"
#include "app/lab/calibrate/batch_points.h"
#include "app/support/statistics.h"

namespace facet {
namespace {

constexpr int kRounds = 3;
static_assert(kBatchRounds == kRounds + 2);
constexpr int kIterations = 12;
constexpr double kFirstSigmaPx = 0.5;
constexpr double kCauchyWidth = 1.0;     // standard deviations
constexpr double kOutlier = 5.0;         // standard deviations
constexpr double kMadToSigma = 1.4826;   // of a normal distribution
constexpr double kLeastSigmaPx = 0.02;   // exact data of tests
constexpr double kGaugeSigma = 1e-4;     // of the first keyframe's position (m) and yaw (rad)
constexpr double kStartGyroBias = 0.1;   // rad/s
constexpr double kStartAccelBias = 1.0;  // m/s^2
constexpr double kHeldShare = 1e-6;      // of the prior's sigma, for entries held at the given value
// Errors along a track are not independent: n sightings count as n / kTrackDependence. With this value, errors of
// calibrations found in rendered flights are as large as their standard deviations say.
constexpr double kTrackDependence = 6.0;
constexpr std::size_t kMinKeyframes = 10;
constexpr std::size_t kMinPoints = 50;

/// One flight being fitted. The states of `flight_` are linearization points; `tangents_` are zero between rounds.
class Batch {
public:
    Batch(const RecordedFlight& flight, const BatchOptions& options)
        : flight_(flight), options_(options), prior_(options.prior_sigma) {}

    Status solve(BatchResult& out);

private:
    Status run_round(bool frees_calibration);
    void add_sightings(ceres::Problem& problem);
    void add_inertial(ceres::Problem& problem);
    void add_priors(ceres::Problem& problem);
    double* pose(std::size_t k) { return tangents_[k].data(); }
    double* motion(std::size_t k) { return tangents_[k].data() + kPoseDim; }
    SightingCost cost_of(const BatchSighting& sighting) const;
    std::vector<SightingResidual> residuals() const;
    void weigh(const std::vector<SightingResidual>& residuals, bool drops_outliers);
    Status spread(ceres::Problem& problem, RigVector& sigma);
    /// @return whether any entry was held
    bool hold_unseen();

    RecordedFlight flight_;
    const BatchOptions& options_;
    RigVector prior_;
    RigVector correction_ = RigVector::Zero();
    RigVector sigma_ = RigVector::Zero();
    BatchPoints points_;
    InertialChain chain_;
    std::vector<Tangent> tangents_;
    double sigma_px_ = kFirstSigmaPx;
    std::size_t rounds_done_ = 0;
};

SightingCost Batch::cost_of(const BatchSighting& s) const {
    const auto k = static_cast<std::size_t>(s.keyframe);
    const RecordedKeyframe& keyframe = flight_.keyframes[k];
    const StereoRig& rig = options_.given.rig;
    return {.px = s.px,
            .inverse_sigma = 1.0 / (std::sqrt(kTrackDependence) * sigma_px_),
            .T_W_B = keyframe.state.T_W_B(),
            .v_W = keyframe.state.v_W_B,
            .w_B = chain_.w_B[k],
            .lag_s = (keyframe.image_stamp - keyframe.stamp).seconds(),
            .lens = (s.camera == 0 ? rig.left : rig.right).intrinsics(),
            .T_B_C = s.camera == 0 ? rig.T_B_C0 : rig.T_B_C1};
}

void Batch::add_sightings(ceres::Problem& problem) {
    // Owned by the problem, once.
    auto* loss = new ceres::CauchyLoss(kCauchyWidth / std::sqrt(kTrackDependence));
    for (const BatchSighting& s : points_.sightings) {
        const auto camera = static_cast<std::size_t>(s.camera);
        problem.AddResidualBlock(new VisionCost(new SightingCost(cost_of(s))), loss,
                                 pose(static_cast<std::size_t>(s.keyframe)), correction_.data() + kBatchMount[camera],
                                 correction_.data() + kBatchLens[camera], correction_.data() + kBatchTime,
                                 points_.p_W[static_cast<std::size_t>(s.point)].data());
    }
}

void Batch::add_inertial(ceres::Problem& problem) {
    for (std::size_t k = 0; k + 1 < flight_.keyframes.size(); ++k) {
        problem.AddResidualBlock(
            new InertialCost(chain_.factors[k], flight_.keyframes[k].state, flight_.keyframes[k + 1].state), nullptr,
            pose(k), motion(k), pose(k + 1), motion(k + 1));
    }
}

void Batch::add_priors(ceres::Problem& problem) {
    // Yaw is the turn about W's z axis: the third row of R_W_B.
    Eigen::Matrix<double, 4, kPoseDim, Eigen::RowMajor> gauge = decltype(gauge)::Zero();
    gauge.block<3, 3>(0, 3).setIdentity();
    gauge.block<1, 3>(3, 0) = flight_.keyframes[0].state.q_W_B.toRotationMatrix().row(2);
    problem.AddResidualBlock(new LinearCost<4, kPoseDim>(gauge / kGaugeSigma), nullptr, pose(0));
    Eigen::Matrix<double, 9, 9, Eigen::RowMajor> start = decltype(start)::Zero();
    start.diagonal().segment<3>(3).setConstant(1.0 / kStartGyroBias);
    start.diagonal().segment<3>(6).setConstant(1.0 / kStartAccelBias);
    problem.AddResidualBlock(new LinearCost<9, 9>(start), nullptr, motion(0));
    const auto weights = [&](int offset, int size) {
        Eigen::VectorXd w(size);
        for (int i = 0; i < size; ++i) {
            const double sigma = prior_(offset + i);
            w(i) = 1.0 / (sigma > 0.0 ? sigma : kHeldShare);
        }
        return Eigen::MatrixXd(w.asDiagonal());
    };
    for (const int lens : kBatchLens) {
        problem.AddResidualBlock(new LinearCost<kBatchLensDim, kBatchLensDim>(weights(lens, kBatchLensDim)), nullptr,
                                 correction_.data() + lens);
    }
    for (const int mount : kBatchMount) {
        problem.AddResidualBlock(new LinearCost<kBatchMountDim, kBatchMountDim>(weights(mount, kBatchMountDim)),
                                 nullptr, correction_.data() + mount);
    }
    problem.AddResidualBlock(new LinearCost<1, 1>(weights(kBatchTime, 1)), nullptr, correction_.data() + kBatchTime);
}

/// One round about the present states: fits everything, then moves the linearization points there.
/// @param frees_calibration  else it stays as it is
Status Batch::run_round(bool frees_calibration) {
    FACET_TRY(integrate_chain(flight_, options_.noise, options_.limits, options_.gravity, chain_));
    tangents_.assign(flight_.keyframes.size(), Tangent{});
    ceres::Problem problem;
    add_sightings(problem);
    add_inertial(problem);
    add_priors(problem);
    auto* ordering = new ceres::ParameterBlockOrdering;
    for (Eigen::Vector3d& p_W : points_.p_W) {
        ordering->AddElementToGroup(p_W.data(), 0);
    }
    for (std::size_t k = 0; k < flight_.keyframes.size(); ++k) {
        ordering->AddElementToGroup(pose(k), 1);
        ordering->AddElementToGroup(motion(k), 1);
    }
    for (const int block : {kBatchLens[0], kBatchLens[1], kBatchMount[0], kBatchMount[1], kBatchTime}) {
        ordering->AddElementToGroup(correction_.data() + block, 1);
        if (!frees_calibration) {
            problem.SetParameterBlockConstant(correction_.data() + block);
        }
    }
    ceres::Solver::Options solver;
    solver.linear_solver_ordering.reset(ordering);
    solver.linear_solver_type = ceres::SPARSE_SCHUR;
    solver.max_num_iterations = kIterations;
    solver.num_threads = 1;  // sums of several would depend on their timing
    solver.logging_type = ceres::SILENT;
    solver.function_tolerance = 1e-5;
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &problem, &summary);
    ++rounds_done_;
    if (options_.progress) {
        options_.progress(rounds_done_);
    }
    if (!summary.IsSolutionUsable()) {
        return Status::kDegenerate;
    }
    if (frees_calibration) {
        FACET_TRY(spread(problem, sigma_));
    }
    for (std::size_t k = 0; k < tangents_.size(); ++k) {
        flight_.keyframes[k].state = moved(flight_.keyframes[k].state, tangents_[k]);
    }
    tangents_.assign(tangents_.size(), Tangent{});
    return Status::kOk;
}

/// Standard deviations of the corrections: columns of the inverse of J^T J, in which points and keyframes come first.
Status Batch::spread(ceres::Problem& problem, RigVector& sigma) {
    ceres::Problem::EvaluateOptions evaluate;
    for (Eigen::Vector3d& p_W : points_.p_W) {
        evaluate.parameter_blocks.push_back(p_W.data());
    }
    for (std::size_t k = 0; k < tangents_.size(); ++k) {
        evaluate.parameter_blocks.push_back(pose(k));
        evaluate.parameter_blocks.push_back(motion(k));
    }
    for (const int block : {kBatchLens[0], kBatchLens[1], kBatchMount[0], kBatchMount[1], kBatchTime}) {
        evaluate.parameter_blocks.push_back(correction_.data() + block);
    }
    ceres::CRSMatrix crs;
    if (!problem.Evaluate(evaluate, nullptr, nullptr, nullptr, &crs)) {
        return Status::kDegenerate;
    }
    using Rows = Eigen::SparseMatrix<double, Eigen::RowMajor>;
    const Rows jacobian = Eigen::Map<const Rows>(crs.num_rows, crs.num_cols, static_cast<int>(crs.values.size()),
                                                 crs.rows.data(), crs.cols.data(), crs.values.data());
    const Eigen::SparseMatrix<double> normal = jacobian.transpose() * jacobian;
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> ldlt(normal);
    if (ldlt.info() != Eigen::Success) {
        return Status::kDegenerate;
    }
    for (int i = 0; i < kBatchDim; ++i) {
        const int column = crs.num_cols - kBatchDim + i;
        const Eigen::VectorXd x = ldlt.solve(Eigen::VectorXd::Unit(crs.num_cols, column));
        if (!(x(column) > 0.0)) {
            return Status::kDegenerate;
        }
        sigma(i) = std::sqrt(x(column));
    }
    return Status::kOk;
}

std::vector<SightingResidual> Batch::residuals() const {
    std::vector<SightingResidual> out;
    out.reserve(points_.sightings.size());
    const Tangent zero{};
    for (const BatchSighting& s : points_.sightings) {
        SightingCost cost = cost_of(s);
        cost.inverse_sigma = 1.0;
        const auto camera = static_cast<std::size_t>(s.camera);
        Eigen::Vector2d error = Eigen::Vector2d::Constant(1e3);  // behind the camera: an outlier
        cost(zero.data(), correction_.data() + kBatchMount[camera], correction_.data() + kBatchLens[camera],
             correction_.data() + kBatchTime, points_.p_W[static_cast<std::size_t>(s.point)].data(), error.data());
        out.push_back({s.camera, s.px, -error});
    }
    return out;
}

/// Learns the noise of sightings, and leaves out those far beyond it.
void Batch::weigh(const std::vector<SightingResidual>& residuals, bool drops_outliers) {
    std::vector<double> sizes;
    for (const SightingResidual& r : residuals) {
        sizes.push_back(std::abs(r.error_px.x()));
        sizes.push_back(std::abs(r.error_px.y()));
    }
    // Points take up degrees of freedom.
    const double rows = 2.0 * static_cast<double>(residuals.size());
    const double share = std::max(0.2, 1.0 - 3.0 * static_cast<double>(points_.p_W.size()) / rows);
    sigma_px_ = std::max(kLeastSigmaPx, kMadToSigma * OrderStatistics(std::move(sizes)).median() / std::sqrt(share));
    if (!drops_outliers) {
        return;
    }
    std::vector<BatchSighting> kept;
    for (std::size_t i = 0; i < residuals.size(); ++i) {
        if (residuals[i].error_px.norm() < kOutlier * sigma_px_) {
            kept.push_back(points_.sightings[i]);
        }
    }
    std::vector<int> count(points_.p_W.size(), 0);
    for (const BatchSighting& s : kept) {
        ++count[static_cast<std::size_t>(s.point)];
    }
    std::vector<int> number(count.size(), -1);
    BatchPoints left;
    for (const BatchSighting& s : kept) {
        const auto point = static_cast<std::size_t>(s.point);
        if (count[point] < 3) {
            continue;
        }
        if (number[point] < 0) {
            number[point] = static_cast<int>(left.p_W.size());
            left.p_W.push_back(points_.p_W[point]);
        }
        left.sightings.push_back(s);
        left.sightings.back().point = number[point];
    }
    points_ = std::move(left);
}

bool Batch::hold_unseen() {
    bool holds = false;
    for (int i = 0; i < kBatchDim; ++i) {
        if (prior_(i) > 0.0 && sigma_(i) > kUnseenShare * prior_(i)) {
            prior_(i) *= kHeldShare;
            holds = true;
        }
    }
    return holds;
}

Status Batch::solve(BatchResult& out) {
    points_ = triangulate_points(flight_, options_.given);
    if (flight_.keyframes.size() < kMinKeyframes || points_.p_W.size() < kMinPoints) {
        return Status::kDegenerate;
    }
    FACET_TRY(run_round(false));
    weigh(residuals(), false);
    BatchResult result;
    result.before = residuals();
    for (int round = 0; round < kRounds; ++round) {
        FACET_TRY(run_round(true));
        weigh(residuals(), true);
    }
    result.sigma = sigma_;
    if (hold_unseen()) {
        FACET_TRY(run_round(true));
        weigh(residuals(), false);
        for (int i = 0; i < kBatchDim; ++i) {
            correction_(i) = prior_(i) < options_.prior_sigma(i) ? 0.0 : correction_(i);
        }
    }
    result.correction = correction_;
    result.pixel_sigma = sigma_px_;
    result.keyframes = static_cast<int>(flight_.keyframes.size());
    result.points = static_cast<int>(points_.p_W.size());
    result.sightings = static_cast<int>(points_.sightings.size());
    result.after = residuals();
    out = std::move(result);
    return Status::kOk;
}

}  // namespace

bool has_batch_solver() { return true; }

Status solve_batch(const RecordedFlight& flight, const BatchOptions& options, BatchResult& out) {
    return Batch(flight, options).solve(out);
}

}  // namespace facet
