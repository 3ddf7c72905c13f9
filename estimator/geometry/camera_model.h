// SPDX-License-Identifier: BSD-2-Clause
// Cameras of eight lens models: project and unproject, with Jacobians.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "platform/base/status.h"

namespace facet {

/// Lens distortion applied to the normalised image point (x, y) = (X/Z, Y/Z), r^2 = x^2 + y^2.
enum class Distortion : std::uint8_t {
    kNone,
    /// coeffs k1 k2 p1 p2: x' = x (1 + k1 r^2 + k2 r^4) + 2 p1 x y + p2 (r^2 + 2 x^2); y' likewise. [Brown66]
    kRadialTangential,
    /// coeffs k1 k2 k3 k4: theta = atan(r), theta' = theta (1 + k1 theta^2 + ... + k4 theta^8). [Kannala06]
    kEquidistant,
    kRational,      ///< coeffs k1 k2 p1 p2, more k3 k4 k5 k6: lens/radial_tangential.h
    kUnified,       ///< coeffs k1 k2 p1 p2, more xi: lens/unified.h
    kDoubleSphere,  ///< coeffs xi alpha: lens/double_sphere.h
    kEucm,          ///< coeffs alpha beta: lens/eucm.h
    kFov,           ///< coeffs w: lens/fov.h
};

/// How many of CameraIntrinsics::coeffs a model has.
constexpr int coefficient_count(Distortion distortion) {
    switch (distortion) {
        case Distortion::kNone: return 0;
        case Distortion::kFov: return 1;
        case Distortion::kDoubleSphere:
        case Distortion::kEucm: return 2;
        default: return 4;
    }
}

/// Intrinsic parameters of one camera (px).
struct CameraIntrinsics {
    int width = 0;
    int height = 0;
    double fx = 0.0;
    double fy = 0.0;
    double cx = 0.0;
    double cy = 0.0;
    Distortion distortion = Distortion::kNone;
    std::array<double, 4> coeffs{};  ///< those that are refined in flight
    std::array<double, 4> more{};    ///< those of kRational and kUnified that are not
};

/// A camera and its lens, for what lies before it. Camera frame C: z forward, x right, y down. Pixel (0, 0) is the
/// centre of the top left pixel. Immutable after construction; reentrant. No heap, no exceptions.
class CameraModel {
public:
    CameraModel() = default;
    explicit CameraModel(const CameraIntrinsics& intrinsics);

    /// kInvalidArgument if a size, focal length or coefficient is not finite or not positive where it must be, or if
    /// the distortion folds inside the image (its radial part is not increasing up to the image corner).
    static Status validate(const CameraIntrinsics& intrinsics);

    const CameraIntrinsics& intrinsics() const { return k_; }
    /// Pixels per unit of a normalised point on the axis: turns normalised residuals into pixels.
    double focal_px() const { return focal_px_; }

    /// Pixel of a point in front of the camera.
    ///   u = fx x' + cx, v = fy y' + cy with (x', y') = distort(X/Z, Y/Z)
    /// @param p_C         point in C (m)
    /// @param uv          pixel (px)
    /// @param d_uv_d_p_C  2x3 (px/m); nullptr to skip
    /// @return kDegenerate if Z <= 1e-6 or the point lies beyond the model's valid angle (outputs untouched).
    Status project(const Eigen::Vector3d& p_C, Eigen::Vector2d& uv,
                   Eigen::Matrix<double, 2, 3>* d_uv_d_p_C = nullptr) const;

    /// Normalised undistorted point (x, y) = (X/Z, Y/Z) of a pixel, by Gauss-Newton on the distortion (at most 20
    /// steps).
    /// @param uv        pixel (px)
    /// @param xy        normalised point (-)
    /// @param d_xy_d_uv 2x2 (1/px); nullptr to skip
    /// @return kDegenerate if the inversion does not reach 1e-10 (outputs untouched).
    Status unproject(const Eigen::Vector2d& uv, Eigen::Vector2d& xy, Eigen::Matrix2d* d_xy_d_uv = nullptr) const;

    /// Distorted normalised point and its 2x2 Jacobian (nullptr to skip).
    Eigen::Vector2d distort(const Eigen::Vector2d& xy, Eigen::Matrix2d* d_out_d_xy = nullptr) const;

    /// Derivative of the pixel with respect to the normalised undistorted point: 2x2 (px).
    Eigen::Matrix2d d_uv_d_xy(const Eigen::Vector2d& xy) const;

    /// Whether the pixel is this far inside the circle in which the model is used. A fisheye's circle lies inside its
    /// image and hides the corners; that of other lenses contains the image.
    bool in_lens(const Eigen::Vector2d& uv, double border_px) const {
        const Eigen::Vector2d distorted((uv.x() - k_.cx) / k_.fx, (uv.y() - k_.cy) / k_.fy);
        const double radius = lens_radius_ - border_px / (0.5 * (k_.fx + k_.fy));
        return radius > 0.0 && distorted.squaredNorm() < radius * radius;
    }

    /// Whether the pixel is this far inside the image and the lens's circle.
    bool in_image(const Eigen::Vector2d& uv, double border_px) const {
        return uv.x() >= border_px && uv.y() >= border_px && uv.x() <= k_.width - 1 - border_px &&
               uv.y() <= k_.height - 1 - border_px && in_lens(uv, border_px);
    }
    /// Largest undistorted radius r the model is used for: where the distortion stops being increasing, or 10.
    double max_radius() const { return max_radius_; }

private:
    CameraIntrinsics k_;
    double focal_px_ = 0.0;
    double max_radius_ = 10.0;
    double lens_radius_ = 10.0;  ///< distorted, of the points at max_radius_; tangential distortion left out
};

}  // namespace facet
