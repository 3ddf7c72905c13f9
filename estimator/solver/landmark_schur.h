// SPDX-License-Identifier: BSD-2-Clause
// Elimination of one landmark from the normal equations of the keyframes that see it.
#pragma once

#include <Eigen/Core>
#include <array>

#include "estimator/factors/coplanarity_factor.h"
#include "estimator/factors/stereo_factor.h"
#include "estimator/solver/camera_term_sums.h"
#include "estimator/solver/reduced_system.h"

namespace facet {

/// Collects the linearized measurements of one landmark, eliminates the point, and adds the rest to the system.
///
/// With A = d_r_d_pose (stacked, one block of 6 columns per keyframe) and B = d_r_d_point, the cost |r + A dx + B dl|^2
/// is minimised over dl in closed form, dl = -(B^T B)^-1 B^T (r + A dx), which leaves for the poses
///   H  = A^T A - A^T B (B^T B)^-1 B^T A,     g = A^T r - A^T B (B^T B)^-1 B^T r.      [Forster17] eq. (30), [Ceres]
/// A co-planarity residual adds a row to A and B, and three columns to A that belong to the plane.
/// Parameters of single cameras are more columns of A, shared by all measurements.
/// The point's chart does not matter: any invertible change of B's columns cancels.
/// Thread-bound. No heap.
class LandmarkSchur {
public:
    /// @param cameras  takes the part of the parameters of single cameras, for measurements that have a Jacobian by
    ///                 them; nullptr: none has. Must outlive the elimination.
    void clear(CameraTermSums* cameras = nullptr);

    /// Where the next measurement is to be linearized.
    StereoLinearization& next() { return terms_[static_cast<std::size_t>(count_)].linearization; }
    /// Adds what next() holds as a measurement by this keyframe (each keyframe at most once, ascending).
    void add(int keyframe);

    /// Number of measurements added, and the residual of the i-th.
    int count() const { return count_; }
    const StereoResidual& residual(int i) const { return terms_[static_cast<std::size_t>(i)].linearization; }

    /// Adds a co-planarity residual with the plane whose variables begin at this row of the system; at most one.
    void add_plane(int row, const CoplanarityLinearization& linearization);

    /// Variance of a linear function j . dl of the point, given all poses and the measurements added so far; infinite
    /// if they do not constrain the point.
    double point_variance(const Eigen::RowVector3d& j) const;

    /// What the inverse depth of every point is taken to be known to (1/m, 1 sigma): nothing, but far above rounding.
    static constexpr double kRhoBound = 1000.0;
    /// Keeps a point without parallax definite: its inverse depth is known to kRhoBound, and pulled nowhere. A prior
    /// that pulls is anchored in the world as long as it has no Jacobian by the host: every point then pushes the
    /// window along its view, in a direction that nothing else has a say in.
    void bound_rho();

    /// Eliminates the point and adds the rest to the system, that of single cameras to their sums.
    /// @return kDegenerate if the point's information is singular (system and sums untouched).
    Status eliminate_into(ReducedSystem& system);

    /// The same for the gradient alone, without the Jacobians by poses and cameras: of what next() holds, the residual
    /// and its Jacobian by the point are used.
    /// @param gradient  gradient(i, r) is the StereoGradient J^T r of the i-th measurement
    template <class Gradient>
    Status eliminate_gradient_into(ReducedSystem& system, const Gradient& gradient) {
        Eigen::Vector3d point_step;
        FACET_TRY(solve_for_point(point_step));
        // With the point's step dl = -(B^T B)^-1 B^T r the gradient is A^T (r + B dl).
        for (int i = 0; i < count_; ++i) {
            const StereoResidual& l = terms_[static_cast<std::size_t>(i)].linearization;
            const Eigen::Vector4d r = l.r + l.d_r_d_point.lazyProduct(point_step);
            add_gradient(i, gradient(i, r), system);
        }
        add_plane_gradient(point_step, system);
        return Status::kOk;
    }

private:
    Status solve_for_point(Eigen::Vector3d& step) const;
    void add_gradient(int i, const StereoGradient& gradient, ReducedSystem& system) const;
    void add_plane_gradient(const Eigen::Vector3d& point_step, ReducedSystem& system) const;
    void multiply_by_point();
    void eliminate_cameras(const Eigen::Vector3d& g_white);
    void eliminate_plane_into(ReducedSystem& system, const Eigen::Vector3d& g_white) const;

    /// Padded to whole vectors: rows below those of the pose are zero, and are added to those of the velocity without
    /// effect.
    static constexpr int kPadded = StereoLinearization::kPaddedPoseDim;
    struct Term {
        int keyframe = 0;
        StereoLinearization linearization;
        Eigen::Matrix<double, kPadded, 3> h_pose_point;
    };
    struct PlaneTerm {
        int row = -1;  ///< none
        CoplanarityLinearization linearization;
        Eigen::Matrix3d h_plane_point;
    };
    int count_ = 0;
    CameraTermSums* cameras_ = nullptr;
    Eigen::Matrix<double, CameraTermSums::kPaddedDim, 3> h_cameras_point_;
    PlaneTerm plane_;
    std::array<Term, kMaxKeyframes + 1> terms_;  ///< one more, so that there is always a next one
    Eigen::Matrix3d h_point_ = Eigen::Matrix3d::Zero();
    Eigen::Vector3d g_point_ = Eigen::Vector3d::Zero();
};

}  // namespace facet
