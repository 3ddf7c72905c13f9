// SPDX-License-Identifier: BSD-2-Clause
// Finds points of the left image in the right one.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "estimator/frontend/epipolar_geometry.h"
#include "estimator/frontend/epipolar_scan.h"
#include "estimator/frontend/frontend_config.h"
#include "estimator/frontend/image_pyramid.h"
#include "estimator/frontend/patch_aligner.h"
#include "estimator/geometry/stereo_rig.h"
#include "platform/base/status.h"

namespace facet {

struct StereoMatch {
    Eigen::Vector2d right_uv = Eigen::Vector2d::Zero();  ///< distorted pixel
    Eigen::Vector2d right_xy = Eigen::Vector2d::Zero();  ///< normalised, in C1, by the lens as given
    double inverse_depth = 0.0;                          ///< 1 / Z in C0 (1/m)
    Eigen::Vector3d p_C0 = Eigen::Vector3d::Zero();      ///< on the left ray of the lens as given (m)
};

/// Unless the depth is roughly known, the curve of the point in the right image (EpipolarGeometry) is searched for
/// inverse depths in [0, 1 / min_depth] by normalised correlation on level 1, a stretch at a time (EpipolarScan); the
/// best place must stand out from every other one, so that repeated patterns stay unmatched rather than being matched
/// wrongly. The place is refined by Lucas-Kanade to level 0, which may leave the curve, and must pass the backward
/// check, the limit on the epipolar distance, and the test for positive depth. The limit is
///   hypot(kStereoEpipolar_px, 6 sigma),   sigma of the line by the uncertainty of the calibration:
/// wide until the calibration is found, for noise and slant alone afterwards. Both images are distorted ones; the patch
/// is warped by the map between the two views. Heap: in configure() only. Thread-bound.
class StereoMatcher {
public:
    Status configure(const FrontendConfig& config, const StereoRig& rig);

    /// The calibration as it is known now; configure() forgets it.
    void correct(const CameraCorrections& corrections) { geometry_.correct(corrections); }

    /// @param left_uv             distorted pixel in the left image
    /// @param known_inverse_depth from an earlier match (1/m), or negative to search
    /// @return kNotFound if the point is outside the right image or nothing correlates; kDegenerate if the match is
    ///         ambiguous or failed a check (match untouched).
    Status match(const ImagePyramid& left, const ImagePyramid& right, const Eigen::Vector2d& left_uv,
                 double known_inverse_depth, StereoMatch& match);

private:
    using Ray = EpipolarGeometry::Ray;
    bool place(const Ray& ray, double inverse_depth, PatchPose& pose) const;
    float score_at(const ImagePyramid& right, const Ray& ray, double inverse_depth) const;
    /// Fills scores_ at inverse depths 0, step, 2 step ...
    void score_curve(const ImagePyramid& left, const ImagePyramid& right, const Ray& ray, double step, int steps);
    /// Best score near scores_[i], where the peak of a fine texture may lie between the samples, and its inverse depth.
    float peak(const ImagePyramid& right, const Ray& ray, double step, int i, double& inverse_depth) const;
    bool is_unique(const ImagePyramid& right, const Ray& ray, double step, std::span<const float> scores, int best,
                   float best_score, int apart) const;
    Status search(const ImagePyramid& left, const ImagePyramid& right, const Ray& ray, double& inverse_depth);
    Status refine(const ImagePyramid& left, const ImagePyramid& right, const Ray& ray, double inverse_depth,
                  StereoMatch& match);

    FrontendConfig config_;
    EpipolarGeometry geometry_;
    PatchAligner aligner_;
    EpipolarScan scan_;
    PatchTemplate patch_;
    PatchTemplate back_;
    std::vector<float> scores_;  ///< along the curve
};

}  // namespace facet
