// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/local_map.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "estimator/geometry/cholesky3.h"
#include "estimator/window/landmark_triangulation.h"

namespace facet {
namespace {

constexpr int kMotionDim = kStateDim - kPoseDim;  // velocity and biases, after the pose
using MotionMatrix = Eigen::Matrix<double, kMotionDim, kMotionDim>;
static_assert(kVel == kPoseDim && kBiasAccel + 3 == kStateDim);

StateCovariance inverse(const Eigen::LLT<StateCovariance>& llt) {
    StateCovariance root = StateCovariance::Identity();
    llt.matrixL().solveInPlace(root);
    return root.transpose() * root;
}

}  // namespace

Status newest_information(const ReducedSystem& system, StateCovariance& information) {
    const auto h = system.h();
    MotionMatrix s;
    for (int k = 0; k < system.keyframes(); ++k) {
        const int row = system.offset(k);
        information = h.block<kStateDim, kStateDim>(row, row).selfadjointView<Eigen::Lower>();
        if (k > 0) {
            const Eigen::LLT<MotionMatrix> llt(s);
            if (llt.info() != Eigen::Success) {
                return Status::kDegenerate;
            }
            Eigen::Matrix<double, kMotionDim, kStateDim> w =
                h.block<kStateDim, kMotionDim>(row, system.offset(k - 1) + kPoseDim).transpose();
            llt.matrixL().solveInPlace(w);
            information.noalias() -= w.transpose() * w;
        }
        s = information.bottomRightCorner<kMotionDim, kMotionDim>();
    }
    return information.allFinite() ? Status::kOk : Status::kDegenerate;
}

Status LocalMap::build(const WindowState& state, const WindowCameras& cameras, const ReducedSystem& system) {
    clear();
    if (system.keyframes() != static_cast<int>(state.keyframes.size()) || state.keyframes.empty()) {
        return Status::kDegenerate;
    }
    FACET_TRY(facet::newest_information(system, newest_information_));
    const Eigen::LLT<StateCovariance> llt(newest_information_);
    if (llt.info() != Eigen::Success) {
        return Status::kDegenerate;
    }
    newest_covariance_ = inverse(llt);
    for (int i = 0; i < state.landmarks.size(); ++i) {
        add(state.landmarks[i], state, cameras);
    }
    return Status::kOk;
}

void LocalMap::add(const Landmark& landmark, const WindowState& state, const WindowCameras& cameras) {
    const int newest = static_cast<int>(state.keyframes.size()) - 1;
    // A landmark seen once has a point only if the right camera saw it too.
    if (landmark.observations.empty() || landmark.observations.back().keyframe != newest || !landmark.has_point ||
        points_.size() == points_.capacity()) {
        return;
    }
    const int host = landmark.observations.front().keyframe;
    MapPoint out;
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    information(2, 2) = 1.0 / (kRhoPriorSigma * kRhoPriorSigma);
    StereoLinearization l;
    for (const LandmarkObservation& o : landmark.observations) {
        const StereoView& view = cameras.view(o.keyframe, host);
        const bool is_newest = o.keyframe == newest;
        const Status status =
            is_newest ? linearize_stereo(o.measurement, cameras.geometry(), view, view, cameras.R_B_W_lin(newest),
                                         landmark.point, cameras.loss(landmark), nullptr, l)
                      : linearize_point(o.measurement, cameras.geometry(), view, view, landmark.point,
                                        cameras.loss(landmark), l);
        if (!ok(status)) {
            return;
        }
        information.noalias() += l.d_r_d_point.transpose().lazyProduct(l.d_r_d_point);
    }
    Cholesky3 cholesky;
    if (!ok(cholesky.factorize(information))) {
        return;
    }
    Eigen::Matrix3d root = Eigen::Matrix3d::Identity();
    cholesky.whiten_rows(root);  // L^-T
    out.covariance.noalias() = root * root.transpose();
    // l is that of the newest keyframe now.
    const Eigen::Matrix<double, 4, kPoseDim> d_r_d_pose = l.d_r_d_T_W_B_transposed.topRows<kPoseDim>().transpose();
    out.d_point_d_pose.noalias() = -out.covariance * (l.d_r_d_point.transpose() * d_r_d_pose);
    out.weight = l.weights(0);
    const double to_unweighted = 1.0 / std::sqrt(out.weight);
    out.residual = to_unweighted * l.r.head<2>();
    out.d_residual_d_point = to_unweighted * l.d_r_d_point.topRows<2>();
    out.d_residual_d_pose = to_unweighted * d_r_d_pose.topRows<2>() + out.d_residual_d_point * out.d_point_d_pose;
    out.id = landmark.id;
    out.host = host;
    out.point = landmark.point;
    points_.push_back(out);
}

const MapPoint* LocalMap::find(LandmarkId id) const {
    const auto at = std::lower_bound(points_.begin(), points_.end(), id,
                                     [](const MapPoint& p, LandmarkId wanted) { return p.id.value < wanted.value; });
    return at != points_.end() && at->id == id ? &*at : nullptr;
}

}  // namespace facet
