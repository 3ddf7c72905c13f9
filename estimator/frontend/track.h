// SPDX-License-Identifier: BSD-2-Clause
// What the front-end remembers of one track between frames.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "estimator/frontend/patch_aligner.h"
#include "platform/base/timestamp.h"
#include "platform/base/typed_id.h"

namespace facet {

/// Between keyframes tracks take turns: each is followed in every so manyth frame. So many earlier images are kept.
inline constexpr int kMaxTurns = 2;

struct Track {
    LandmarkId id;
    std::uint32_t age_frames = 0;
    std::uint32_t turn = 0;                              ///< tells in which frames its turn is: counts tracks begun
    int unseen = 0;                                      ///< frames since it was seen; 0: it is seen in this one
    int span = 0;                                        ///< frames from its sighting before to its newest
    int slot = 0;                                        ///< of its template in the tracker
    PatchPose pose;                                      ///< of the template in the left image now
    Eigen::Vector2d xy = Eigen::Vector2d::Zero();        ///< normalised, in C0 now
    Eigen::Vector2d velocity = Eigen::Vector2d::Zero();  ///< of xy, rotation compensated (1/s)
    bool has_velocity = false;
    bool in_keyframe = false;  ///< was seen in the last keyframe
    Eigen::Vector2d keyframe_xy = Eigen::Vector2d::Zero();
    bool has_depth = false;      ///< matched in stereo at the last keyframe
    double inverse_depth = 0.0;  ///< in C0 there (1/m)
    bool has_right = false;      ///< matched in this frame
    Eigen::Vector2d right_uv = Eigen::Vector2d::Zero();
    Eigen::Vector2d right_xy = Eigen::Vector2d::Zero();
    Timestamp watched_since;                                   ///< for being fixed to the vehicle
    Eigen::Vector2d watched_uv = Eigen::Vector2d::Zero();      ///< where it was then
    Eigen::Vector3d watched_ray_B0 = Eigen::Vector3d::Zero();  ///< its ray then, in the body's axes at the first frame
    bool is_fixed = false;                                     ///< stayed where it was while the vehicle turned
    bool goes_with_world = false;                              ///< went about as the vehicle turned
};

}  // namespace facet
