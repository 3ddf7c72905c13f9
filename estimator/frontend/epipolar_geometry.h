// SPDX-License-Identifier: BSD-2-Clause
// Where a point of the left image may be seen in the right one, as far as the calibration is known.
#pragma once

#include <Eigen/Core>

#include "estimator/geometry/lens_correction.h"
#include "estimator/geometry/stereo_rig.h"
#include "estimator/values/camera_corrections.h"
#include "platform/base/status.h"

namespace facet {

/// An epipolar line may be off by this many of its sigmas: three if the calibration is twice as bad as its prior says.
inline constexpr double kLineSigmas = 6.0;

/// The point at inverse depth rho on the ray of a left pixel is seen in the right image along
///   p_C1(rho) = R_C1_C0 [xy; 1] + rho p_C1_C0,
/// with the rig as given and corrected by what is known of it. Normalised points come as the lens as given undistorts
/// them: that is how the smoother takes observations. No heap. Thread-bound.
class EpipolarGeometry {
public:
    /// The ray of a left pixel, in the right camera.
    struct Ray {
        Eigen::Vector2d uv;            ///< left, pixel
        Eigen::Vector2d given_xy;      ///< left, normalised, by the lens as given
        Eigen::Vector3d direction_C1;  ///< R_C1_C0 [xy; 1], xy corrected
        Eigen::Matrix<double, 3, 2> d_direction_d_uv;
        Eigen::Matrix<double, 2, kLensDim> d_xy_d_lens;  ///< zero without corrections
    };
    /// A right pixel against the curve of a ray.
    struct Place {
        Eigen::Vector2d given_xy;    ///< right, normalised, by the lens as given
        double inverse_depth = 0.0;  ///< where the curve comes nearest, 1 / Z in C0 (1/m)
        double off_px = 0.0;         ///< distance from the epipolar line, >= 0
        double off_sigma_px = 0.0;   ///< of the line itself, by the uncertainty of the corrections
    };

    /// The rig as given; forgets corrections.
    void configure(const StereoRig& rig);

    /// From now on the rig is the given one with these corrections. A right lens that would fold is left as given where
    /// the curve is drawn.
    void correct(const CameraCorrections& corrections);

    /// @return kDegenerate if the pixel cannot be undistorted (ray untouched).
    Status ray_of(const Eigen::Vector2d& left_uv, Ray& ray) const;

    /// Right pixel of the ray at an inverse depth.
    /// @param d_right_d_left  how the pixel moves with the left one, of a surface that faces the left camera
    /// @return kDegenerate if the point is not in front of the right camera (outputs untouched).
    Status point_at(const Ray& ray, double inverse_depth, Eigen::Vector2d& right_uv,
                    Eigen::Matrix2f& d_right_d_left) const;

    /// @return kDegenerate if the pixel cannot be undistorted (place untouched).
    Status compare(const Ray& ray, const Eigen::Vector2d& right_uv, Place& place) const;

    bool in_right_image(const Eigen::Vector2d& uv, double border_px) const {
        return given_.right.in_image(uv, border_px);
    }
    /// Whether a right pixel is this far inside the circle that its lens shows.
    bool in_right_lens(const Eigen::Vector2d& uv, double border_px) const {
        return given_.right.in_lens(uv, border_px);
    }

private:
    void set_right(const CameraModel& camera, const Se3& T_B_C1);
    double line_sigma(const Ray& ray, const Eigen::Vector2d& normal,
                      const Eigen::Matrix<double, 2, kLensDim>& d_right_d_lens, double inverse_depth) const;

    StereoRig given_;
    CameraModel right_;  ///< corrected
    bool is_corrected_ = false;
    CameraCorrections corrections_;
    Eigen::Matrix3d R_C1_C0_ = Eigen::Matrix3d::Identity();
    Eigen::Matrix3d R_C1_B_ = Eigen::Matrix3d::Identity();
    Eigen::Vector3d p_C1_C0_ = Eigen::Vector3d::Zero();
};

}  // namespace facet
