// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/geometry/lens_correction.h"

#include <Eigen/LU>
#include <cmath>

#include "estimator/geometry/lens/double_sphere.h"
#include "estimator/geometry/lens/eucm.h"
#include "estimator/geometry/lens/fov.h"
#include "estimator/geometry/lens/radial_tangential.h"
#include "estimator/geometry/lens/unified.h"

namespace facet {
namespace {

Eigen::Matrix<double, 2, 4> radial_tangential(const Eigen::Vector2d& xy) {
    const double r2 = xy.squaredNorm();
    const double x = xy.x();
    const double y = xy.y();
    Eigen::Matrix<double, 2, 4> d;
    d << r2 * xy, r2 * r2 * xy, Eigen::Vector2d(2.0 * x * y, r2 + 2.0 * y * y),
        Eigen::Vector2d(r2 + 2.0 * x * x, 2.0 * x * y);
    return d;
}

/// dD/dk.
Eigen::Matrix<double, 2, 4> d_distorted_d_coefficients(const CameraIntrinsics& k, const Eigen::Vector2d& xy) {
    Eigen::Matrix<double, 2, 4> d = Eigen::Matrix<double, 2, 4>::Zero();
    const double r2 = xy.squaredNorm();
    const auto set_radial = [&](const RadialScale& s) { d.leftCols<2>() << s.d_k[0] * xy, s.d_k[1] * xy; };
    switch (k.distortion) {
        case Distortion::kRadialTangential: d = radial_tangential(xy); break;
        case Distortion::kUnified: d = radial_tangential(UnifiedLens::scale_at(k.more.data(), r2).value * xy); break;
        case Distortion::kRational:
            d = radial_tangential(xy);
            set_radial(RationalLens::scale_at(k.coeffs.data(), k.more.data(), r2));
            break;
        case Distortion::kDoubleSphere: set_radial(DoubleSphereLens::scale_at(k.coeffs.data(), r2)); break;
        case Distortion::kEucm: set_radial(EucmLens::scale_at(k.coeffs.data(), r2)); break;
        case Distortion::kFov: set_radial(FovLens::scale_at(k.coeffs.data(), r2)); break;
        case Distortion::kEquidistant:
        case Distortion::kNone: break;
    }
    if (k.distortion == Distortion::kEquidistant && r2 > 0.0) {
        const double r = std::sqrt(r2);
        const double theta = std::atan(r);
        const double t2 = theta * theta;
        const Eigen::Vector2d first = (theta * t2 / r) * xy;
        d << first, t2 * first, t2 * t2 * first, t2 * t2 * t2 * first;
    }
    return d;
}

}  // namespace

CameraIntrinsics corrected(const CameraIntrinsics& intrinsics, const LensCorrection& correction) {
    CameraIntrinsics k = intrinsics;
    k.fx *= 1.0 + correction(0);
    k.fy *= 1.0 + correction(1);
    k.cx += correction(2);
    k.cy += correction(3);
    for (int i = 0; i < coefficient_count(k.distortion); ++i) {
        k.coeffs[static_cast<std::size_t>(i)] += correction(kLensDistortion + i);
    }
    return k;
}

CameraModel corrected(const CameraModel& camera, const LensCorrection& correction) {
    const CameraIntrinsics k = corrected(camera.intrinsics(), correction);
    return ok(CameraModel::validate(k)) ? CameraModel(k) : camera;
}

LensJacobian d_xy_d_lens(const CameraModel& camera, const Eigen::Vector2d& xy) {
    const CameraIntrinsics& k = camera.intrinsics();
    Eigen::Matrix2d d_distorted_d_xy;
    const Eigen::Vector2d distorted = camera.distort(xy, &d_distorted_d_xy);
    Eigen::Matrix<double, 2, kLensDim> d = Eigen::Matrix<double, 2, kLensDim>::Zero();
    d(0, 0) = -distorted.x();
    d(1, 1) = -distorted.y();
    d(0, 2) = -1.0 / k.fx;
    d(1, 3) = -1.0 / k.fy;
    d.rightCols<4>() = -d_distorted_d_coefficients(k, xy);
    return (d_distorted_d_xy.inverse() * d).cast<float>();
}

}  // namespace facet
