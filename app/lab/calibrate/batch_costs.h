// SPDX-License-Identifier: BSD-2-Clause
// The residuals of a batch as Ceres wants them; for batch.cpp only.
#pragma once

#include <ceres/autodiff_cost_function.h>
#include <ceres/sized_cost_function.h>

#include <algorithm>
#include <array>

#include "app/lab/calibrate/sighting_cost.h"
#include "estimator/factors/imu_factor.h"

namespace facet {

// Eigen's alignment differs between this program and the installed Ceres: only plain arrays cross the border.

/// Of a keyframe's state about its linearization point, order [theta p v bg ba].
using Tangent = std::array<double, kStateDim>;

inline NavState moved(const NavState& state, const Tangent& d) {
    return state.box_plus(Eigen::Map<const Eigen::Matrix<double, kStateDim, 1>>(d.data()));
}

/// The inertial factor as a function of both keyframes' tangents [theta p] [v bg ba] about their linearization points.
/// The factor's Jacobian is that of a perturbation at the present state: for the rotation Jr(theta) leads there.
class InertialCost : public ceres::SizedCostFunction<kStateDim, kPoseDim, 9, kPoseDim, 9> {
public:
    InertialCost(const ImuFactor& factor, const NavState& i, const NavState& j) : factor_(factor), i_(i), j_(j) {}

    bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
        const NavState i = moved(i_, joined(x[0], x[1]));
        const NavState j = moved(j_, joined(x[2], x[3]));
        ImuFactorLinearization at;
        factor_.linearize(i, j, i, j, at);
        std::copy_n(at.r.data(), kStateDim, residuals);
        if (jacobians != nullptr) {
            turn(x[0], at.d_r_d_i);
            turn(x[2], at.d_r_d_j);
            write(at.d_r_d_i, jacobians[0], jacobians[1]);
            write(at.d_r_d_j, jacobians[2], jacobians[3]);
        }
        return true;
    }

private:
    using Jacobian = Eigen::Matrix<double, kStateDim, kStateDim>;

    static Tangent joined(const double* pose, const double* motion) {
        Tangent d;
        std::copy_n(pose, kPoseDim, d.begin());
        std::copy_n(motion, 9, d.begin() + kPoseDim);
        return d;
    }
    static void turn(const double* pose, Jacobian& d) {
        const Eigen::Matrix3d to_present = so3_right_jacobian(Eigen::Map<const Eigen::Vector3d>(pose));
        d.leftCols<3>() = (d.leftCols<3>() * to_present).eval();
    }
    static void write(const Jacobian& d, double* pose, double* motion) {
        if (pose != nullptr) {
            Eigen::Map<Eigen::Matrix<double, kStateDim, kPoseDim, Eigen::RowMajor>> out(pose);
            out = d.leftCols<kPoseDim>();
        }
        if (motion != nullptr) {
            Eigen::Map<Eigen::Matrix<double, kStateDim, 9, Eigen::RowMajor>> out(motion);
            out = d.rightCols<9>();
        }
    }

    ImuFactor factor_;
    NavState i_;
    NavState j_;
};

/// A linear residual A x of one block of parameters.
template <int kRows, int kColumns>
class LinearCost : public ceres::SizedCostFunction<kRows, kColumns> {
public:
    using Matrix = Eigen::Matrix<double, kRows, kColumns, kColumns == 1 ? Eigen::ColMajor : Eigen::RowMajor>;
    explicit LinearCost(const Matrix& a) : a_(a) {}

    bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
        Eigen::Map<Eigen::Matrix<double, kRows, 1>> out(residuals);
        out = a_ * Eigen::Map<const Eigen::Matrix<double, kColumns, 1>>(x[0]);
        if (jacobians != nullptr && jacobians[0] != nullptr) {
            std::copy_n(a_.data(), kRows * kColumns, jacobians[0]);
        }
        return true;
    }

private:
    Matrix a_;
};

/// See SightingCost: pose, mount, lens, time offset, point.
using VisionCost = ceres::AutoDiffCostFunction<SightingCost, 2, kPoseDim, kBatchMountDim, kBatchLensDim, 1, 3>;

}  // namespace facet
