// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/solver/landmark_schur.h"

#include <limits>

#include "estimator/geometry/cholesky3.h"
#include "platform/base/assert.h"

namespace facet {

static_assert(StereoLinearization::kPaddedPoseDim <= kStateDim, "padding must fall into the keyframe's own rows");

void LandmarkSchur::clear(int cameras_row) {
    count_ = 0;
    cameras_row_ = cameras_row;
    if (cameras_row >= 0) {
        h_cameras_.setZero();
        h_cameras_point_.setZero();
        g_cameras_.setZero();
    }
    plane_.row = -1;
    h_point_.setZero();
    g_point_.setZero();
}

void LandmarkSchur::add(int keyframe, const StereoLinearization& linearization) {
    FACET_ASSERT(count_ < kMaxKeyframes && (count_ == 0 || terms_[count_ - 1].keyframe < keyframe));
    const auto& a_t = linearization.d_r_d_T_W_B_transposed;
    const auto& b = linearization.d_r_d_point;
    PoseTerm& term = terms_[count_++];
    term.keyframe = keyframe;
    term.h_pose.noalias() = a_t.lazyProduct(a_t.topRows<kPoseDim>().transpose());
    term.h_pose_point.noalias() = a_t.lazyProduct(b);
    term.g_pose.noalias() = a_t.lazyProduct(linearization.r);
    h_point_.noalias() += b.transpose().lazyProduct(b);
    g_point_.noalias() += b.transpose().lazyProduct(linearization.r);
    if (cameras_row_ >= 0) {
        FACET_ASSERT(linearization.has_cameras);
        const auto& c_t = linearization.d_r_d_cameras_transposed;
        term.h_pose_cameras.noalias() = a_t.lazyProduct(c_t.transpose());
        h_cameras_.noalias() += c_t.lazyProduct(c_t.transpose());
        h_cameras_point_.noalias() += c_t.lazyProduct(b);
        g_cameras_.noalias() += c_t.lazyProduct(linearization.r);
    }
}

void LandmarkSchur::add_plane(int row, const CoplanarityLinearization& linearization) {
    FACET_ASSERT(plane_.row < 0 && row >= 0);
    const Eigen::RowVector3d& a = linearization.d_r_d_plane;
    const Eigen::RowVector3d& b = linearization.d_r_d_point;
    plane_.row = row;
    plane_.h_plane.noalias() = a.transpose() * a;
    plane_.h_plane_point.noalias() = a.transpose() * b;
    plane_.g_plane.noalias() = a.transpose() * linearization.r;
    h_point_.noalias() += b.transpose() * b;
    g_point_.noalias() += b.transpose() * linearization.r;
}

double LandmarkSchur::point_variance(const Eigen::RowVector3d& j) const {
    Cholesky3 cholesky;
    if (!ok(cholesky.factorize(h_point_))) {
        return std::numeric_limits<double>::infinity();
    }
    return cholesky.whiten(j.transpose()).squaredNorm();
}

void LandmarkSchur::add_rho_prior(double rho, double sigma) {
    const double information = 1.0 / (sigma * sigma);
    h_point_(2, 2) += information;
    g_point_(2) += information * rho;
}

Status LandmarkSchur::eliminate_into(ReducedSystem& system) {
    Cholesky3 cholesky;
    FACET_TRY(cholesky.factorize(h_point_));
    // h_pose_point becomes W = A^T B L^-T, so that A^T B (L L^T)^-1 B^T A = W W^T.
    const Eigen::Vector3d g_white = cholesky.whiten(g_point_);
    auto h = system.h();
    auto g = system.g();
    for (int i = 0; i < count_; ++i) {
        PoseTerm& ti = terms_[i];
        cholesky.whiten_rows(ti.h_pose_point);
        const int row = system.offset(ti.keyframe);
        for (int j = 0; j < i; ++j) {
            h.block<kPadded, kPoseDim>(row, system.offset(terms_[j].keyframe)) -=
                ti.h_pose_point.lazyProduct(terms_[j].h_pose_point.topRows<kPoseDim>().transpose());
        }
        ti.h_pose -= ti.h_pose_point.lazyProduct(ti.h_pose_point.topRows<kPoseDim>().transpose());
        h.block<kPadded, kPoseDim>(row, row) += ti.h_pose;
        g.segment<kPadded>(row) += ti.g_pose - ti.h_pose_point * g_white;
    }
    if (cameras_row_ >= 0) {
        cholesky.whiten_rows(h_cameras_point_);
        eliminate_cameras_into(system, g_white);
    }
    if (plane_.row >= 0) {
        cholesky.whiten_rows(plane_.h_plane_point);
        eliminate_plane_into(system, g_white);
    }
    return Status::kOk;
}

void LandmarkSchur::eliminate_cameras_into(ReducedSystem& system, const Eigen::Vector3d& g_white) const {
    const auto& w = h_cameras_point_;
    auto h = system.h();
    h.block<kCameraTermsDim, kCameraTermsDim>(cameras_row_, cameras_row_) += h_cameras_ - w.lazyProduct(w.transpose());
    system.g().segment<kCameraTermsDim>(cameras_row_) += g_cameras_ - w * g_white;
    for (int i = 0; i < count_; ++i) {
        h.block<kPadded, kCameraTermsDim>(system.offset(terms_[i].keyframe), cameras_row_) +=
            terms_[i].h_pose_cameras - terms_[i].h_pose_point.lazyProduct(w.transpose());
    }
}

void LandmarkSchur::eliminate_plane_into(ReducedSystem& system, const Eigen::Vector3d& g_white) const {
    const Eigen::Matrix3d& w = plane_.h_plane_point;
    system.h().block<kPlaneDim, kPlaneDim>(plane_.row, plane_.row) += plane_.h_plane - w * w.transpose();
    system.g().segment<kPlaneDim>(plane_.row) += plane_.g_plane - w * g_white;
    if (cameras_row_ >= 0) {
        FACET_ASSERT(plane_.row > cameras_row_);
        system.h().block<kPlaneDim, kCameraTermsDim>(plane_.row, cameras_row_) -=
            w.lazyProduct(h_cameras_point_.transpose());
    }
    for (int i = 0; i < count_; ++i) {
        system.h().block<kPadded, kPlaneDim>(system.offset(terms_[i].keyframe), plane_.row) -=
            terms_[i].h_pose_point.lazyProduct(w.transpose());
    }
}

}  // namespace facet
