// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/solver/landmark_schur.h"

#include <limits>

#include "estimator/geometry/cholesky3.h"
#include "platform/base/assert.h"

namespace facet {

static_assert(StereoLinearization::kPaddedPoseDim <= kStateDim, "padding must fall into the keyframe's own rows");

namespace {

constexpr int kPaddedRight = StereoLinearization::kPaddedRightDim;

/// Adds J^T J of two rows to h, of which only the lower triangle counts: blocks of four columns from the diagonal on.
template <int kDim, int kFirst = 0, class Block>
void add_square(const Eigen::Matrix<double, kDim, 2>& j_t, Block& h) {
    if constexpr (kFirst < kDim) {
        h.template block<kDim - kFirst, 4>(kFirst, kFirst) +=
            j_t.template bottomRows<kDim - kFirst>().lazyProduct(j_t.template middleRows<4>(kFirst).transpose());
        add_square<kDim, kFirst + 4>(j_t, h);
    }
}

}  // namespace

void LandmarkSchur::clear(CameraTermSums* cameras) {
    count_ = 0;
    cameras_ = cameras;
    plane_.row = -1;
    h_point_.setZero();
    g_point_.setZero();
}

void LandmarkSchur::add(int keyframe) {
    FACET_ASSERT(count_ < kMaxKeyframes && (count_ == 0 || terms_[count_ - 1].keyframe < keyframe));
    Term& term = terms_[count_++];
    term.keyframe = keyframe;
    const StereoLinearization& l = term.linearization;
    const auto& b = l.d_r_d_point;
    h_point_.noalias() += b.transpose().lazyProduct(b);
    g_point_.noalias() += b.transpose().lazyProduct(l.r);
}

void LandmarkSchur::add_plane(int row, const CoplanarityLinearization& linearization) {
    FACET_ASSERT(plane_.row < 0 && row >= 0);
    const Eigen::RowVector3d& b = linearization.d_r_d_point;
    plane_.row = row;
    plane_.linearization = linearization;
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

void LandmarkSchur::bound_rho() { h_point_(2, 2) += 1.0 / (kRhoBound * kRhoBound); }

/// Parameters by the point: A^T B.
void LandmarkSchur::multiply_by_point() {
    if (cameras_ != nullptr) {
        h_cameras_point_.setZero();
    }
    for (int i = 0; i < count_; ++i) {
        const StereoLinearization& l = terms_[i].linearization;
        const auto& b = l.d_r_d_point;
        terms_[i].h_pose_point.noalias() = l.d_r_d_T_W_B_transposed.lazyProduct(b);
        if (cameras_ == nullptr) {
            continue;
        }
        FACET_ASSERT(l.has_cameras);
        h_cameras_point_.topRows<kLensDim>().noalias() += l.d_r_d_left_lens_transposed.lazyProduct(b.topRows<2>());
        if (l.has_right) {
            h_cameras_point_.bottomRows<kPaddedRight>().noalias() +=
                l.d_r_d_right_camera_transposed.lazyProduct(b.bottomRows<2>());
        }
    }
    if (plane_.row >= 0) {
        plane_.h_plane_point.noalias() =
            plane_.linearization.d_r_d_plane.transpose() * plane_.linearization.d_r_d_point;
    }
}

Status LandmarkSchur::solve_for_point(Eigen::Vector3d& step) const {
    Cholesky3 cholesky;
    FACET_TRY(cholesky.factorize(h_point_));
    step = -cholesky.solve(g_point_);
    return Status::kOk;
}

void LandmarkSchur::add_gradient(int i, const StereoGradient& gradient, ReducedSystem& system) const {
    const Term& term = terms_[static_cast<std::size_t>(i)];
    system.g().segment<kPoseDim>(system.offset(term.keyframe)) += gradient.pose;
    if (cameras_ == nullptr) {
        return;
    }
    cameras_->g.head<kLensDim>() += gradient.left_lens;
    if (term.linearization.has_right) {
        cameras_->g.segment<kRightCameraDim>(kLensDim) += gradient.right_camera;
    }
}

void LandmarkSchur::add_plane_gradient(const Eigen::Vector3d& point_step, ReducedSystem& system) const {
    if (plane_.row >= 0) {
        const CoplanarityLinearization& l = plane_.linearization;
        system.g().segment<kPlaneDim>(plane_.row) += l.d_r_d_plane.transpose() * (l.r + l.d_r_d_point.dot(point_step));
    }
}

Status LandmarkSchur::eliminate_into(ReducedSystem& system) {
    Cholesky3 cholesky;
    FACET_TRY(cholesky.factorize(h_point_));
    FACET_ASSERT(system.has_matrix());
    multiply_by_point();
    // h_pose_point becomes W = A^T B L^-T, so that A^T B (L L^T)^-1 B^T A = W W^T.
    const Eigen::Vector3d g_white = cholesky.whiten(g_point_);
    auto h = system.h();
    auto g = system.g();
    for (int i = 0; i < count_; ++i) {
        Term& ti = terms_[i];
        cholesky.whiten_rows(ti.h_pose_point);
        const int row = system.offset(ti.keyframe);
        for (int j = 0; j < i; ++j) {
            h.block<kPadded, kPoseDim>(row, system.offset(terms_[j].keyframe)) -=
                ti.h_pose_point.lazyProduct(terms_[j].h_pose_point.topRows<kPoseDim>().transpose());
        }
        const auto& a_t = ti.linearization.d_r_d_T_W_B_transposed;
        h.block<kPadded, kPoseDim>(row, row) +=
            a_t.lazyProduct(a_t.topRows<kPoseDim>().transpose()) -
            ti.h_pose_point.lazyProduct(ti.h_pose_point.topRows<kPoseDim>().transpose());
        g.segment<kPadded>(row) += a_t.lazyProduct(ti.linearization.r) - ti.h_pose_point.lazyProduct(g_white);
    }
    if (cameras_ != nullptr) {
        cholesky.whiten_rows(h_cameras_point_);
        eliminate_cameras(g_white);
    }
    if (plane_.row >= 0) {
        cholesky.whiten_rows(plane_.h_plane_point);
        eliminate_plane_into(system, g_white);
    }
    return Status::kOk;
}

void LandmarkSchur::eliminate_cameras(const Eigen::Vector3d& g_white) {
    // A^T C - W_A W_C^T as one product of five columns: [A^T W_A] [C^T -W_C]^T.
    Eigen::Matrix<double, kPadded, 5> pose;
    Eigen::Matrix<double, kLensDim, 5> left;
    Eigen::Matrix<double, kPaddedRight, 5> right;
    const auto& w = h_cameras_point_;
    const auto w_left = w.topRows<kLensDim>();
    const auto w_right = w.bottomRows<kPaddedRight>();
    CameraTermSums& sums = *cameras_;
    auto h_left = sums.h.topLeftCorner<kLensDim, kLensDim>();
    auto h_right = sums.h.bottomRightCorner<kPaddedRight, kPaddedRight>();
    left.rightCols<3>() = -w_left;
    right.rightCols<3>() = -w_right;
    bool has_right = false;
    for (int i = 0; i < count_; ++i) {
        const StereoLinearization& l = terms_[i].linearization;
        const auto& w_pose = terms_[i].h_pose_point;
        CameraTermSums::PoseBlock& h_pose = sums.h_pose[static_cast<std::size_t>(terms_[i].keyframe)];
        const auto& a_t = l.d_r_d_T_W_B_transposed;
        pose.rightCols<3>() = w_pose;
        pose.leftCols<2>() = a_t.leftCols<2>();
        left.leftCols<2>() = l.d_r_d_left_lens_transposed;
        h_pose.leftCols<kLensDim>() += pose.lazyProduct(left.transpose());
        add_square(l.d_r_d_left_lens_transposed, h_left);
        sums.g.head<kLensDim>() += l.d_r_d_left_lens_transposed.lazyProduct(l.r.head<2>());
        if (l.has_right) {
            has_right = true;
            pose.leftCols<2>() = a_t.rightCols<2>();
            right.leftCols<2>() = l.d_r_d_right_camera_transposed;
            h_pose.rightCols<kPaddedRight>() += pose.lazyProduct(right.transpose());
            add_square(l.d_r_d_right_camera_transposed, h_right);
            sums.g.tail<kPaddedRight>() += l.d_r_d_right_camera_transposed.lazyProduct(l.r.tail<2>());
        } else {
            h_pose.rightCols<kPaddedRight>() -= w_pose.lazyProduct(w_right.transpose());
        }
    }
    h_left -= w_left.lazyProduct(w_left.transpose());
    sums.g.head<kLensDim>() -= w_left.lazyProduct(g_white);
    if (has_right) {
        h_right -= w_right.lazyProduct(w_right.transpose());
        sums.h.bottomLeftCorner<kPaddedRight, kLensDim>() -= w_right.lazyProduct(w_left.transpose());
        sums.g.tail<kPaddedRight>() -= w_right.lazyProduct(g_white);
    }
}

void LandmarkSchur::eliminate_plane_into(ReducedSystem& system, const Eigen::Vector3d& g_white) const {
    const Eigen::Matrix3d& w = plane_.h_plane_point;
    const Eigen::RowVector3d& a = plane_.linearization.d_r_d_plane;
    system.h().block<kPlaneDim, kPlaneDim>(plane_.row, plane_.row) += a.transpose() * a - w * w.transpose();
    system.g().segment<kPlaneDim>(plane_.row) += a.transpose() * plane_.linearization.r - w * g_white;
    if (cameras_ != nullptr) {
        FACET_ASSERT(plane_.row > cameras_->row);
        system.h().block<kPlaneDim, kCameraTermsDim>(plane_.row, cameras_->row) -=
            w.lazyProduct(h_cameras_point_.topRows<kCameraTermsDim>().transpose());
    }
    for (int i = 0; i < count_; ++i) {
        system.h().block<kPadded, kPlaneDim>(system.offset(terms_[i].keyframe), plane_.row) -=
            terms_[i].h_pose_point.lazyProduct(w.transpose());
    }
}

}  // namespace facet
