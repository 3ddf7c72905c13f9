// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/solver/landmark_schur.h"

#include <Eigen/Cholesky>
#include <limits>

#include "platform/base/assert.h"

namespace facet {

void LandmarkSchur::clear() {
    count_ = 0;
    plane_.row = -1;
    h_point_.setZero();
    g_point_.setZero();
}

void LandmarkSchur::add(int keyframe, const StereoLinearization& linearization) {
    FACET_ASSERT(count_ < kMaxKeyframes && (count_ == 0 || terms_[count_ - 1].keyframe < keyframe));
    const auto& a = linearization.d_r_d_T_W_B;
    const auto& b = linearization.d_r_d_point;
    PoseTerm& term = terms_[count_++];
    term.keyframe = keyframe;
    term.h_pose.noalias() = a.transpose() * a;
    term.h_pose_point.noalias() = a.transpose() * b;
    term.g_pose.noalias() = a.transpose() * linearization.r;
    h_point_.noalias() += b.transpose() * b;
    g_point_.noalias() += b.transpose() * linearization.r;
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
    const Eigen::LLT<Eigen::Matrix3d> llt(h_point_);
    if (llt.info() != Eigen::Success) {
        return std::numeric_limits<double>::infinity();
    }
    return llt.matrixL().solve(j.transpose()).squaredNorm();
}

void LandmarkSchur::add_rho_prior(double rho, double sigma) {
    const double information = 1.0 / (sigma * sigma);
    h_point_(2, 2) += information;
    g_point_(2) += information * rho;
}

Status LandmarkSchur::eliminate_into(ReducedSystem& system) {
    const Eigen::LLT<Eigen::Matrix3d> llt(h_point_);
    if (llt.info() != Eigen::Success) {
        return Status::kDegenerate;
    }
    // h_pose_point becomes W = A^T B L^-T, so that A^T B (L L^T)^-1 B^T A = W W^T.
    const Eigen::Vector3d g_white = llt.matrixL().solve(g_point_);
    for (int i = 0; i < count_; ++i) {
        PoseTerm& term = terms_[i];
        term.h_pose_point = llt.matrixL().solve(term.h_pose_point.transpose()).transpose();
    }
    for (int i = 0; i < count_; ++i) {
        const PoseTerm& ti = terms_[i];
        for (int j = 0; j < i; ++j) {
            system.add_pose_block(ti.keyframe, terms_[j].keyframe,
                                  -ti.h_pose_point * terms_[j].h_pose_point.transpose());
        }
        system.add_pose_block(ti.keyframe, ti.keyframe, ti.h_pose - ti.h_pose_point * ti.h_pose_point.transpose());
        system.add_pose_gradient(ti.keyframe, ti.g_pose - ti.h_pose_point * g_white);
    }
    if (plane_.row >= 0) {
        plane_.h_plane_point = llt.matrixL().solve(plane_.h_plane_point.transpose()).transpose();
        eliminate_plane_into(system, g_white);
    }
    return Status::kOk;
}

void LandmarkSchur::eliminate_plane_into(ReducedSystem& system, const Eigen::Vector3d& g_white) const {
    const Eigen::Matrix3d& w = plane_.h_plane_point;
    system.h().block<kPlaneDim, kPlaneDim>(plane_.row, plane_.row) += plane_.h_plane - w * w.transpose();
    system.g().segment<kPlaneDim>(plane_.row) += plane_.g_plane - w * g_white;
    for (int i = 0; i < count_; ++i) {
        system.h().block<kPoseDim, kPlaneDim>(system.offset(terms_[i].keyframe), plane_.row).noalias() -=
            terms_[i].h_pose_point * w.transpose();
    }
}

}  // namespace facet
