// SPDX-License-Identifier: BSD-2-Clause
// The image of a point as a function of keyframe, camera and point, for automatic differentiation.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "app/lab/calibrate/rig_parameters.h"
#include "estimator/geometry/camera_model.h"
#include "estimator/geometry/lens/double_sphere.h"
#include "estimator/geometry/lens/eucm.h"
#include "estimator/geometry/lens/fov.h"
#include "estimator/geometry/lens/radial_tangential.h"
#include "estimator/geometry/lens/unified.h"
#include "estimator/geometry/se3.h"

namespace facet {

/// Exp: R^3 -> SO(3) for any scalar that behaves as a number; first order below 1e-9 rad.
template <class T>
Eigen::Quaternion<T> exp_of(const Eigen::Matrix<T, 3, 1>& theta) {
    using std::cos;
    using std::sin;
    using std::sqrt;
    const T angle2 = theta.squaredNorm();
    if (!(angle2 > T(1e-18))) {
        return Eigen::Quaternion<T>(T(1.0), T(0.5) * theta.x(), T(0.5) * theta.y(), T(0.5) * theta.z());
    }
    const T angle = sqrt(angle2);
    const T s = sin(T(0.5) * angle) / angle;
    return Eigen::Quaternion<T>(cos(T(0.5) * angle), s * theta.x(), s * theta.y(), s * theta.z());
}

/// CameraModel::distort with coefficients of any scalar; those that are not refined are the lens's.
template <class T>
Eigen::Matrix<T, 2, 1> distort_with(const CameraIntrinsics& lens, const T* k, const Eigen::Matrix<T, 2, 1>& xy) {
    using std::atan;
    using std::sqrt;
    constexpr std::array<double, 4> kPlain{};
    const T r2 = xy.squaredNorm();
    switch (lens.distortion) {
        case Distortion::kRadialTangential: return RationalLens::distort<T>(k, kPlain.data(), xy);
        case Distortion::kRational: return RationalLens::distort<T>(k, lens.more.data(), xy);
        case Distortion::kUnified: {
            const T xi(lens.more[0]);
            return RationalLens::distort<T>(k, kPlain.data(), xy * UnifiedLens::scale<T>(&xi, r2));
        }
        case Distortion::kDoubleSphere: return xy * DoubleSphereLens::scale<T>(k, r2);
        case Distortion::kEucm: return xy * EucmLens::scale<T>(k, r2);
        case Distortion::kFov: return xy * FovLens::scale<T>(k, r2);
        case Distortion::kEquidistant:
        case Distortion::kNone: break;
    }
    if (lens.distortion == Distortion::kEquidistant && r2 > T(1e-12)) {
        const T r = sqrt(r2);
        const T theta = atan(r);
        const T t2 = theta * theta;
        return xy * (theta * (T(1.0) + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3])))) / r);
    }
    return xy;
}

/// Whitened residual of one image of a point. Parameters: pose of the keyframe's body [theta p] about the linearization
/// point, mount, lens and time offset as corrections (rig_parameters.h), the point in W (m).
///   r = (pi(T_B_C^-1 T_W_B^-1 p_W) - px) / sigma_px
/// The body at the image's time is the keyframe's, moved on by velocity and angular rate over the few milliseconds
/// between the two.
struct SightingCost {
    Eigen::Vector2d px;
    double inverse_sigma = 1.0;  ///< (1/px)
    Se3 T_W_B;                   ///< of the keyframe, linearization point
    Eigen::Vector3d v_W;         ///< (m/s)
    Eigen::Vector3d w_B;         ///< (rad/s)
    double lag_s = 0.0;          ///< the image's time, at no correction, minus the keyframe's
    CameraIntrinsics lens;       ///< given
    Se3 T_B_C;                   ///< given

    template <class T>
    bool operator()(const T* pose, const T* mount, const T* lens_correction, const T* time, const T* point,
                    T* residual) const {
        using Vector3 = Eigen::Matrix<T, 3, 1>;
        using ConstMap = Eigen::Map<const Vector3>;
        const T lag = T(lag_s) + time[0];
        const Eigen::Quaternion<T> q_W_B =
            T_W_B.q.cast<T>() * exp_of<T>(ConstMap(pose)) * exp_of<T>(w_B.cast<T>() * lag);
        const Vector3 p_W_B = T_W_B.p.cast<T>() + ConstMap(pose + 3) + v_W.cast<T>() * lag;
        const Eigen::Quaternion<T> q_B_C = T_B_C.q.cast<T>() * exp_of<T>(ConstMap(mount));
        const Vector3 p_B_C = T_B_C.p.cast<T>() + ConstMap(mount + 3);
        const Vector3 p_B = q_W_B.conjugate() * Vector3(ConstMap(point) - p_W_B);
        const Vector3 p_C = q_B_C.conjugate() * Vector3(p_B - p_B_C);
        if (!(p_C.z() > T(1e-3))) {
            return false;
        }
        T coefficients[4];
        for (int i = 0; i < 4; ++i) {
            coefficients[i] = T(lens.coeffs[static_cast<std::size_t>(i)]) + lens_correction[4 + i];
        }
        const Eigen::Matrix<T, 2, 1> xy(p_C.x() / p_C.z(), p_C.y() / p_C.z());
        const Eigen::Matrix<T, 2, 1> bent = distort_with<T>(lens, coefficients, xy);
        const T u = T(lens.fx) * (T(1.0) + lens_correction[0]) * bent.x() + T(lens.cx) + lens_correction[2];
        const T v = T(lens.fy) * (T(1.0) + lens_correction[1]) * bent.y() + T(lens.cy) + lens_correction[3];
        residual[0] = T(inverse_sigma) * (u - T(px.x()));
        residual[1] = T(inverse_sigma) * (v - T(px.y()));
        return true;
    }
};

}  // namespace facet
