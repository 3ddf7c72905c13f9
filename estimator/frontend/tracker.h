// SPDX-License-Identifier: BSD-2-Clause
// Follows patches through the left images.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "estimator/frontend/frontend_config.h"
#include "estimator/frontend/frontend_types.h"
#include "estimator/frontend/image_pyramid.h"
#include "estimator/frontend/patch_aligner.h"
#include "estimator/frontend/track.h"
#include "estimator/geometry/camera_model.h"
#include "estimator/values/observation.h"
#include "platform/base/status.h"

namespace facet {

/// Motion from an earlier frame to this one, predicted before the image is examined.
struct FrameMotion {
    Eigen::Quaterniond q_C_Cp = Eigen::Quaterniond::Identity();  ///< rotation of the left camera: p_C = q * p_Cp
    double dt_s = 0.0;
};

/// Each track owns a template, cut where the track began, and is aligned with that same template in every frame, so
/// that errors do not accumulate from frame to frame. The affine map from template to image is carried along: each
/// frame turns it by the camera's rotation (the derivative of the rotated bearing through both distortions), and the
/// alignment refines it. The predicted position is the rotated bearing plus the track's own rotation-compensated
/// velocity.
/// Cutting new templates on the way (at a scale of 1.5, or at a correlation of 0.9) was tried: tracks did not last
/// longer, and the drift grew.
/// Heap: in configure() only. Thread-bound.
class Tracker {
public:
    Status configure(const FrontendConfig& config, const CameraModel& camera);

    /// Frees all templates.
    void reset();

    /// Starts a track at uv: takes a template slot and cuts the template.
    /// @return kFull without a free slot; kNotFound or kDegenerate if no template can be cut there (track untouched).
    Status start(const ImagePyramid& image, const Eigen::Vector2d& uv, Track& track);
    void stop(const Track& track) { free_.push_back(track.slot); }

    /// Moves a track from an earlier image, in which it was seen, to the present one.
    /// @return kNotFound if it left the image; kDegenerate if alignment or the backward check failed (track untouched).
    Status follow(const ImagePyramid& earlier, const ImagePyramid& present, const FrameMotion& motion, Track& track);

    /// Searches for a lost track where its landmark is predicted.
    /// @param q_C_Cl  rotation of the left camera since the track was lost: p_C = q * p_Cl
    /// @param shift   from the prediction to where it was found (px)
    /// @return kNotFound if the prediction is outside the image; kDegenerate if nothing there looks like it (outputs
    ///         untouched).
    Status find_again(const ImagePyramid& image, const LandmarkPrediction& prediction, const Eigen::Quaterniond& q_C_Cl,
                      Track& track, Eigen::Vector2d& shift) const;

    const PatchTemplate& patch(const Track& track) const { return templates_[static_cast<std::size_t>(track.slot)]; }
    double border_px() const { return aligner_.border_px(); }

private:
    /// A point of one image, as the camera sees it after a rotation.
    struct TurnedPoint {
        Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
        Eigen::Vector2d xy = Eigen::Vector2d::Zero();  ///< its bearing, turned, normalised
        Eigen::Matrix<double, 2, 3> d_xy_d_rotated = Eigen::Matrix<double, 2, 3>::Zero();
        Eigen::Matrix2d d_xy_d_uv = Eigen::Matrix2d::Zero();  ///< of the bearing before the turn
    };
    /// @param xy  its bearing before the rotation, normalised
    /// @return kNotFound if it is then beside or behind the camera.
    Status turn(const Eigen::Vector2d& xy, const Eigen::Quaterniond& q, TurnedPoint& point) const;
    /// Pixel at which the turned point is seen if it has moved on to xy, and the affine map of its neighbourhood from
    /// the first image to this one, scaled by the factor `grown`. @return kNotFound if no pixel sees xy.
    Status land(const TurnedPoint& point, const Eigen::Vector2d& xy, double grown, Eigen::Vector2d& uv,
                Eigen::Matrix2f& map) const;

    FrontendConfig config_;
    CameraModel camera_;
    PatchAligner aligner_;
    std::vector<PatchTemplate> templates_;
    std::vector<int> free_;
    PatchTemplate probe_;  ///< of the backward check
};

}  // namespace facet
