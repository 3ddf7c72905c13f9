// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/geometry/camera_model.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "estimator/geometry/lens/double_sphere.h"
#include "estimator/geometry/lens/eucm.h"
#include "estimator/geometry/lens/fov.h"
#include "estimator/geometry/lens/radial_tangential.h"
#include "estimator/geometry/lens/unified.h"

namespace facet {
namespace {

constexpr double kMinDepth = 1e-6;
constexpr double kMaxRadius = 10.0;  // 84 degrees off axis
constexpr int kMaxInversionSteps = 20;
constexpr double kInversionTolerance = 1e-10;

/// The factor of the models that have one.
RadialScale scale_of(const CameraIntrinsics& k, double r2) {
    switch (k.distortion) {
        case Distortion::kRational: return RationalLens::scale_at(k.coeffs.data(), k.more.data(), r2);
        case Distortion::kUnified: return UnifiedLens::scale_at(k.more.data(), r2);
        case Distortion::kDoubleSphere: return DoubleSphereLens::scale_at(k.coeffs.data(), r2);
        case Distortion::kEucm: return EucmLens::scale_at(k.coeffs.data(), r2);
        case Distortion::kFov: return FovLens::scale_at(k.coeffs.data(), r2);
        default: return {};
    }
}

/// The point that a model without tangential part bends there; of kUnified as if there were no distortion behind it.
/// Not finite if there is none.
Eigen::Vector2d unbent(const CameraIntrinsics& k, const Eigen::Vector2d& target) {
    const double m2 = target.squaredNorm();
    switch (k.distortion) {
        case Distortion::kUnified: return UnifiedLens::inverse_scale(k.more.data(), m2) * target;
        case Distortion::kDoubleSphere: return DoubleSphereLens::inverse_scale(k.coeffs.data(), m2) * target;
        case Distortion::kEucm: return EucmLens::inverse_scale(k.coeffs.data(), m2) * target;
        case Distortion::kFov: return FovLens::inverse_scale(k.coeffs.data(), m2) * target;
        default: return target;
    }
}

/// Whether the model is one of a lens that may see half of all directions: its image may hold less than its corners.
bool is_wide(Distortion distortion) {
    return distortion != Distortion::kNone && distortion != Distortion::kRadialTangential;
}

/// Derivative of the distorted radius with respect to the undistorted one, tangential part left out.
double radial_slope(const CameraIntrinsics& k, double r) {
    const auto& c = k.coeffs;
    switch (k.distortion) {
        case Distortion::kNone: return 1.0;
        case Distortion::kRadialTangential: {
            const double r2 = r * r;
            return 1.0 + 3.0 * c[0] * r2 + 5.0 * c[1] * r2 * r2;
        }
        case Distortion::kEquidistant: {
            const double t2 = std::atan(r) * std::atan(r);
            return 1.0 + t2 * (3.0 * c[0] + t2 * (5.0 * c[1] + t2 * (7.0 * c[2] + t2 * 9.0 * c[3])));
        }
        default: break;
    }
    // Wide lenses: by the angle, in units of the slope on the axis.
    const double r2 = r * r;
    const RadialScale s = scale_of(k, r2);
    double slope = s.value > 0.0 ? s.slope_by_angle(r2) / scale_of(k, 0.0).value : 0.0;
    if (k.distortion == Distortion::kUnified) {
        const double m2 = s.value * s.value * r2;
        slope *= 1.0 + 3.0 * c[0] * m2 + 5.0 * c[1] * m2 * m2;
    }
    return slope;
}

/// Distorted radius, tangential part left out.
double radial_image(const CameraIntrinsics& k, double r) {
    const auto& c = k.coeffs;
    switch (k.distortion) {
        case Distortion::kNone: return r;
        case Distortion::kRadialTangential: return r * (1.0 + r * r * (c[0] + c[1] * r * r));
        case Distortion::kEquidistant: {
            const double theta = std::atan(r);
            const double t2 = theta * theta;
            return theta * (1.0 + t2 * (c[0] + t2 * (c[1] + t2 * (c[2] + t2 * c[3]))));
        }
        default: break;
    }
    const double m = r * scale_of(k, r * r).value;
    return k.distortion == Distortion::kUnified ? m * (1.0 + m * m * (c[0] + c[1] * m * m)) : m;
}

double find_max_radius(const CameraIntrinsics& k) {
    constexpr double kStep = 0.01;
    constexpr double kMinSlope = 0.05;
    double r = 0.0;
    while (r < kMaxRadius && radial_slope(k, r + kStep) > kMinSlope) {
        r += kStep;
    }
    return r;
}

Eigen::Vector2d distort_radial_tangential(const std::array<double, 4>& c, const Eigen::Vector2d& xy,
                                          Eigen::Matrix2d* d) {
    const double x = xy.x();
    const double y = xy.y();
    const double r2 = x * x + y * y;
    const double radial = 1.0 + r2 * (c[0] + r2 * c[1]);
    if (d != nullptr) {
        const double d_radial = c[0] + 2.0 * c[1] * r2;  // d radial / d r2
        (*d)(0, 0) = radial + 2.0 * x * x * d_radial + 2.0 * c[2] * y + 6.0 * c[3] * x;
        (*d)(0, 1) = 2.0 * x * y * d_radial + 2.0 * c[2] * x + 2.0 * c[3] * y;
        (*d)(1, 0) = (*d)(0, 1);
        (*d)(1, 1) = radial + 2.0 * y * y * d_radial + 6.0 * c[2] * y + 2.0 * c[3] * x;
    }
    return {x * radial + 2.0 * c[2] * x * y + c[3] * (r2 + 2.0 * x * x),
            y * radial + c[2] * (r2 + 2.0 * y * y) + 2.0 * c[3] * x * y};
}

Eigen::Vector2d distort_equidistant(const std::array<double, 4>& c, const Eigen::Vector2d& xy, Eigen::Matrix2d* d) {
    const double r2 = xy.squaredNorm();
    const double r = std::sqrt(r2);
    const double theta = std::atan(r);
    const double t2 = theta * theta;
    const double poly = 1.0 + t2 * (c[0] + t2 * (c[1] + t2 * (c[2] + t2 * c[3])));
    const double slope = 1.0 + t2 * (3.0 * c[0] + t2 * (5.0 * c[1] + t2 * (7.0 * c[2] + t2 * 9.0 * c[3])));
    // scale = theta' / r; near the axis theta / r = 1 - r^2 / 3 and the scale's slope over r tends to 2 k1 - 2 / 3.
    const bool near_axis = r < 1e-4;
    const double scale = near_axis ? 1.0 + r2 * (c[0] - 1.0 / 3.0) : theta * poly / r;
    if (d != nullptr) {
        const double d_scale_over_r = near_axis ? 2.0 * (c[0] - 1.0 / 3.0) : (slope / (1.0 + r2) - scale) / r2;
        *d = scale * Eigen::Matrix2d::Identity() + d_scale_over_r * xy * xy.transpose();
    }
    return scale * xy;
}

Eigen::Vector2d distort_unified(const CameraIntrinsics& k, const Eigen::Vector2d& xy, Eigen::Matrix2d* d) {
    Eigen::Matrix2d d_m_d_xy;
    const Eigen::Vector2d m = scale_of(k, xy.squaredNorm()).bend(xy, d != nullptr ? &d_m_d_xy : nullptr);
    Eigen::Vector2d distorted = distort_radial_tangential(k.coeffs, m, d);
    if (d != nullptr) {
        *d *= d_m_d_xy;
    }
    return distorted;
}

}  // namespace

CameraModel::CameraModel(const CameraIntrinsics& intrinsics)
    : k_(intrinsics),
      focal_px_(0.5 * (k_.fx + k_.fy) * scale_of(k_, 0.0).value),
      max_radius_(find_max_radius(intrinsics)),
      lens_radius_(radial_image(intrinsics, max_radius_)) {}

Status CameraModel::validate(const CameraIntrinsics& k) {
    const bool numbers_ok = std::isfinite(k.fx) && std::isfinite(k.fy) && std::isfinite(k.cx) && std::isfinite(k.cy) &&
                            std::all_of(k.coeffs.begin(), k.coeffs.end(), [](double c) { return std::isfinite(c); }) &&
                            std::all_of(k.more.begin(), k.more.end(), [](double c) { return std::isfinite(c); });
    if (!numbers_ok || k.width <= 0 || k.height <= 0 || k.fx <= 0.0 || k.fy <= 0.0) {
        return Status::kInvalidArgument;
    }
    const CameraModel model(k);
    if (is_wide(k.distortion) && model.max_radius() >= kMaxRadius) {
        return Status::kOk;  // never folds; a fisheye's corners may lie beyond the angle of use
    }
    for (const double u : {0.0, k.width - 1.0}) {
        for (const double v : {0.0, k.height - 1.0}) {
            Eigen::Vector2d xy;
            if (!ok(model.unproject({u, v}, xy))) {
                return Status::kInvalidArgument;
            }
        }
    }
    return Status::kOk;
}

Eigen::Vector2d CameraModel::distort(const Eigen::Vector2d& xy, Eigen::Matrix2d* d_out_d_xy) const {
    switch (k_.distortion) {
        case Distortion::kRadialTangential: return distort_radial_tangential(k_.coeffs, xy, d_out_d_xy);
        case Distortion::kEquidistant: return distort_equidistant(k_.coeffs, xy, d_out_d_xy);
        case Distortion::kRational: return RationalLens::distort(k_.coeffs.data(), k_.more.data(), xy, d_out_d_xy);
        case Distortion::kUnified: return distort_unified(k_, xy, d_out_d_xy);
        case Distortion::kDoubleSphere:
        case Distortion::kEucm:
        case Distortion::kFov: return scale_of(k_, xy.squaredNorm()).bend(xy, d_out_d_xy);
        case Distortion::kNone: break;
    }
    if (d_out_d_xy != nullptr) {
        d_out_d_xy->setIdentity();
    }
    return xy;
}

Eigen::Matrix2d CameraModel::d_uv_d_xy(const Eigen::Vector2d& xy) const {
    Eigen::Matrix2d d_distorted_d_xy;
    distort(xy, &d_distorted_d_xy);
    return Eigen::Vector2d(k_.fx, k_.fy).asDiagonal() * d_distorted_d_xy;
}

Status CameraModel::project(const Eigen::Vector3d& p_C, Eigen::Vector2d& uv,
                            Eigen::Matrix<double, 2, 3>* d_uv_d_p_C) const {
    if (!(p_C.z() > kMinDepth)) {
        return Status::kDegenerate;
    }
    const double inv_z = 1.0 / p_C.z();
    const Eigen::Vector2d xy = p_C.head<2>() * inv_z;
    if (!(xy.squaredNorm() <= max_radius_ * max_radius_)) {
        return Status::kDegenerate;
    }
    Eigen::Matrix2d d_distorted_d_xy;
    const Eigen::Vector2d distorted = distort(xy, d_uv_d_p_C != nullptr ? &d_distorted_d_xy : nullptr);
    uv = {k_.fx * distorted.x() + k_.cx, k_.fy * distorted.y() + k_.cy};
    if (d_uv_d_p_C != nullptr) {
        Eigen::Matrix<double, 2, 3> d_xy_d_p_C;
        d_xy_d_p_C << inv_z, 0.0, -xy.x() * inv_z, 0.0, inv_z, -xy.y() * inv_z;
        *d_uv_d_p_C = Eigen::Vector2d(k_.fx, k_.fy).asDiagonal() * d_distorted_d_xy * d_xy_d_p_C;
    }
    return Status::kOk;
}

Status CameraModel::unproject(const Eigen::Vector2d& uv, Eigen::Vector2d& xy, Eigen::Matrix2d* d_xy_d_uv) const {
    const Eigen::Vector2d target((uv.x() - k_.cx) / k_.fx, (uv.y() - k_.cy) / k_.fy);
    if (!target.allFinite()) {
        return Status::kDegenerate;
    }
    Eigen::Vector2d guess = unbent(k_, target);
    if (!guess.allFinite()) {
        return Status::kDegenerate;
    }
    Eigen::Matrix2d jacobian = Eigen::Matrix2d::Identity();
    for (int step = 0; step < kMaxInversionSteps; ++step) {
        const Eigen::Vector2d error = target - distort(guess, &jacobian);
        const double determinant = jacobian.determinant();
        if (error.squaredNorm() < kInversionTolerance * kInversionTolerance) {
            if (guess.squaredNorm() > max_radius_ * max_radius_ || !(determinant > 0.0)) {
                return Status::kDegenerate;
            }
            xy = guess;
            if (d_xy_d_uv != nullptr) {
                *d_xy_d_uv = jacobian.inverse() * Eigen::Vector2d(1.0 / k_.fx, 1.0 / k_.fy).asDiagonal();
            }
            return Status::kOk;
        }
        if (!(std::abs(determinant) > 1e-9)) {
            return Status::kDegenerate;
        }
        guess += jacobian.inverse() * error;
        const double radius = guess.norm();
        if (radius > max_radius_) {
            guess *= max_radius_ / radius;
        }
    }
    return Status::kDegenerate;
}

}  // namespace facet
