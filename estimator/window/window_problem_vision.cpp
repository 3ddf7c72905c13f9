// SPDX-License-Identifier: BSD-2-Clause
// The landmarks' part of the window problem.
#include <algorithm>
#include <boost/container/static_vector.hpp>
#include <cmath>

#include "estimator/values/stage_scope.h"
#include "estimator/window/landmark_triangulation.h"
#include "estimator/window/window_problem.h"

namespace facet {

void WindowProblem::select_landmarks() {
    constexpr int kSettlingSteps = 3;  // towards new observations, before planes are asked whether points fit
    const StageScope scope(observer_, Stage::kTriangulation);
    refresh();
    for (int i = 0; i < state_->landmarks.size(); ++i) {
        Landmark& landmark = state_->landmarks[i];
        // Seen by one keyframe only, a stereo match still shows where to search for the landmark.
        const bool is_known = (landmark.observations.size() >= 2 || landmark.observations[0].measurement.has_right) &&
                              triangulate_landmark(*state_, *cameras_, *regularity_config_, kSettlingSteps, landmark);
        landmark.is_active = is_known && landmark.observations.size() >= 2;
        landmark.cost = 0.0;
        weights_[static_cast<std::size_t>(i)].count = 0;
    }
}

void WindowProblem::begin_landmarks(const ReducedSystem& system) {
    if (cameras_->estimates_lenses()) {
        camera_sums_.reset(system.keyframes(), kRigDim, system.has_matrix());
    }
}

void WindowProblem::end_landmarks(ReducedSystem& system) const {
    if (cameras_->estimates_lenses()) {
        camera_sums_.add_into(system);
    }
    add_calibration(system);
}

/// Linearizes a landmark's measurements into schur_: for the gradient alone no further than stereo_gradient() asks.
Status WindowProblem::linearize_measurements(const Landmark& landmark, bool with_matrix) {
    const int host = landmark.observations.front().keyframe;
    schur_.clear(cameras_->estimates_lenses() ? &camera_sums_ : nullptr);
    for (const LandmarkObservation& o : landmark.observations) {
        StereoLinearization& l = schur_.next();
        const StereoView& view = cameras_->view(o.keyframe, host);
        const StereoView& view_lin = cameras_->view_lin(o.keyframe, host);
        if (with_matrix) {
            const CameraTerms terms = cameras_->terms(o);
            FACET_TRY(linearize_stereo(o.measurement, cameras_->geometry(), view, view_lin,
                                       cameras_->R_B_W_lin(o.keyframe), landmark.point, cameras_->loss(landmark),
                                       cameras_->estimates_lenses() ? &terms : nullptr, l));
        } else {
            FACET_TRY(linearize_point(o.measurement, cameras_->geometry(), view, view_lin, landmark.point,
                                      cameras_->loss(landmark), l));
        }
        schur_.add(o.keyframe);
    }
    return Status::kOk;
}

Status WindowProblem::eliminate_landmark(const Landmark& landmark, ReducedSystem& system) {
    if (system.has_matrix()) {
        return schur_.eliminate_into(system);
    }
    return schur_.eliminate_gradient_into(system, [&](int i, const Eigen::Vector4d& r) {
        const LandmarkObservation& o = landmark.observations[static_cast<std::size_t>(i)];
        const CameraTerms terms = cameras_->terms(o);
        return stereo_gradient(schur_.residual(i), r, cameras_->geometry(), cameras_->R_B_W_lin(o.keyframe),
                               landmark.point.rho, cameras_->estimates_lenses() ? &terms : nullptr);
    });
}

double WindowProblem::add_landmark(ReducedSystem& system, Landmark& landmark, ObservationWeights* weights) {
    const std::span<const Eigen::Vector2f> known =
        weights != nullptr ? weights->known() : std::span<const Eigen::Vector2f>();
    // A landmark without a cost so far is left out of the whole optimization: had it one from the next step on, that
    // step would look worse by it. One with a cost keeps it, so that leaving it out of a step looks like no gain.
    const bool has_cost = weights == nullptr || weights->count > 0;
    const auto leave_out = [&landmark, has_cost] {
        landmark.is_active = has_cost;
        return landmark.cost;
    };
    // It follows its cameras step by step as they move.
    if (!triangulate_landmark(*state_, *cameras_, *regularity_config_, 1, landmark, known)) {
        return leave_out();
    }
    if (!ok(linearize_measurements(landmark, system.has_matrix()))) {
        return leave_out();
    }
    const double plane_cost = add_plane_height(landmark);
    schur_.bound_rho();
    if (!ok(eliminate_landmark(landmark, system))) {
        return leave_out();
    }
    landmark.cost = plane_cost + measure_fit(landmark);
    if (weights != nullptr) {
        weights->count = schur_.count();
        for (int i = 0; i < schur_.count(); ++i) {
            const StereoResidual& l = schur_.residual(i);
            weights->weights[static_cast<std::size_t>(i)] =
                Eigen::Vector2d(l.weights(0), l.has_right ? l.weights(1) : 0.0).cast<float>();
        }
    }
    return landmark.cost;
}

/// Adds what schur_ holds of a landmark to fit_. @return the robust cost of its measurements
double WindowProblem::measure_fit(Landmark& landmark) {
    LossSums loss;
    int rows = -3;
    boost::container::static_vector<double, 2 * kMaxKeyframes> squares;
    const double sigma_px = cameras_->noise().sigma_px();
    const double variance_px2 = sigma_px * sigma_px;
    for (int i = 0; i < schur_.count(); ++i) {
        const StereoResidual& l = schur_.residual(i);
        loss += l.loss;
        fit_.vision_squared_error_px2 +=
            std::min(l.loss.squared_error * variance_px2, l.loss.points * kBlunderPx * kBlunderPx);
        rows += l.has_right ? 4 : 2;
        const Eigen::Vector2d used(l.weights(0), l.has_right ? l.weights(1) : 0.0);
        fit_.weights += used;
        fit_.weighted_residual_px.head<2>() += sigma_px * std::sqrt(used(0)) * l.r.head<2>();
        fit_.weighted_residual_px.tail<2>() += sigma_px * std::sqrt(used(1)) * l.r.tail<2>();
        for (const double square : l.squares()) {
            squares.push_back(square);
            fit_.vision_squares_px2.add(square * variance_px2);
        }
    }
    landmark.squared_error = loss.squared_error;
    ++fit_.active_landmarks;
    fit_.vision_rows += rows;
    fit_.vision_loss += loss;
    return cameras_->loss(landmark).cost({squares.data(), squares.size()});
}

/// Adds the landmark's height above its plane, if it has one, to schur_. @return its robust cost
double WindowProblem::add_plane_height(Landmark& landmark) {
    if (landmark.plane == Landmark::kNoPlane) {
        return 0.0;
    }
    const WindowPlane& plane = state_->planes[static_cast<std::size_t>(landmark.plane)];
    const HuberLoss loss{regularity_config_->huber_threshold};
    const CameraPose& host = cameras_->left(landmark.observations.front().keyframe);
    CoplanarityLinearization l;
    if (!ok(linearize_coplanarity(plane.plane, plane.linearization_point(), host, landmark.point, plane.sigma_m, loss,
                                  l))) {
        return 0.0;
    }
    // At the optimum the images pull the point off the plane as strongly as the plane pulls it back. With
    // q = w s / sigma^2, s the height's variance by images alone, the free height is therefore e = r (1 + q); its
    // variance is f^2 + s, f how flat surfaces are, s as measured. A single height is judged by f, not by sigma.
    const double q = schur_.point_variance(l.d_r_d_point);
    const double flat = std::pow(regularity_config_->sigma_m / plane.sigma_m, 2);
    landmark.plane_chi2 =
        l.r * l.r / l.weight * (1.0 + q) * (1.0 + q) / (flat + cameras_->observation_variance() * q / l.weight);
    schur_.add_plane(plane_row(landmark.plane), l);
    return l.cost;
}

void WindowProblem::add_calibration(ReducedSystem& system) const {
    const int dim = std::min(calibration_config_->dim(), kRigDim);
    if (dim == 0) {
        return;
    }
    using Columns = Eigen::Matrix<double, kPoseDim, Eigen::Dynamic, 0, kPoseDim, kRigDim>;
    boost::container::static_vector<Columns, kMaxKeyframes> d_pose;
    for (const Keyframe& keyframe : state_->keyframes) {
        const NavState& at = keyframe.linearization_point();
        d_pose.push_back(state_->calibration.d_pose(at.q_W_B.toRotationMatrix(), at.v_W_B, keyframe.w_B).leftCols(dim));
    }
    auto h = system.h();
    auto g = system.g();
    for (int j = 0; j < system.keyframes(); ++j) {
        g.head(dim) +=
            d_pose[static_cast<std::size_t>(j)].transpose().lazyProduct(g.segment<kPoseDim>(system.offset(j)));
    }
    if (!system.has_matrix()) {
        return;
    }
    for (int j = 0; j < system.keyframes(); ++j) {
        Columns column = Columns::Zero(kPoseDim, dim);
        for (int k = 0; k < system.keyframes(); ++k) {
            const Columns& d = d_pose[static_cast<std::size_t>(k)];
            if (j >= k) {
                column.noalias() += h.block<kPoseDim, kPoseDim>(system.offset(j), system.offset(k)).lazyProduct(d);
            } else {
                column.noalias() +=
                    h.block<kPoseDim, kPoseDim>(system.offset(k), system.offset(j)).transpose().lazyProduct(d);
            }
        }
        const Columns& d = d_pose[static_cast<std::size_t>(j)];
        for (int row = dim; row < system.globals(); ++row) {  // single cameras, planes
            h.row(row).head(dim) += h.col(row).segment<kPoseDim>(system.offset(j)).transpose().lazyProduct(d);
        }
        h.block(system.offset(j), 0, kPoseDim, dim) += column;
        h.topLeftCorner(dim, dim) += d.transpose().lazyProduct(column);
    }
}

}  // namespace facet
