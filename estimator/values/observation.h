// SPDX-License-Identifier: BSD-2-Clause
// What front-end and smoother exchange: sightings of landmarks one way, predictions of them the other.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "platform/base/typed_id.h"

namespace facet {

/// One landmark seen in one stereo frame. Normalised coordinates are undistorted, (X/Z, Y/Z) in the camera's frame.
struct FeatureObservation {
    LandmarkId landmark;
    Eigen::Vector2d left_xy = Eigen::Vector2d::Zero();   ///< normalised, in C0 (-)
    Eigen::Vector2d right_xy = Eigen::Vector2d::Zero();  ///< normalised, in C1 (-); only if has_right
    Eigen::Vector2f left_px = Eigen::Vector2f::Zero();   ///< distorted pixel in the left image (px)
    Eigen::Vector2f right_px = Eigen::Vector2f::Zero();  ///< distorted pixel in the right image (px); only if has_right
    bool has_right = false;
    std::uint32_t age_frames = 0;  ///< frames since the track began
};

/// Where the smoother expects one of its landmarks in a frame.
struct LandmarkPrediction {
    LandmarkId landmark;
    bool in_view = false;                               ///< in front of the left camera and within its image
    Eigen::Vector2d left_xy = Eigen::Vector2d::Zero();  ///< normalised, in C0 (-); only if in_view
    double inverse_depth = 0.0;                         ///< 1 / Z in C0 (1/m); only if in_view
};

}  // namespace facet
