// SPDX-License-Identifier: BSD-2-Clause
// What the live view is given of a flight.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "app/foxglove/messages.h"
#include "app/foxglove/scene.h"
#include "estimator/api/estimate.h"

namespace facet {

using ViewFace = SceneFace;
using ViewPlane = ScenePlane;

/// What is known at a frame.
struct ViewState {
    Timestamp stamp;
    bool has_pose = true;  ///< the estimate is to be used
    Se3 T_W_B;
    std::optional<Se3> T_M_W;  ///< the map of places from W, while the pose in it is known
    Se3 T_B_C;                 ///< of the camera that the picture is of
    Health health;
    bool is_keyframe = false;
    MessageTimes times{};
};

/// What the mesh shows at a keyframe.
struct ViewMesh {
    std::vector<ViewFace> faces;
    std::vector<ViewPlane> planes;
};

/// The space at the vehicle's height, for planners in the plane: cells row by row from a corner on, x first.
struct ViewGrid {
    float cell_m = 0.0F;
    int width = 0;
    int height = 0;
    Eigen::Vector3d corner_W = Eigen::Vector3d::Zero();  ///< of the first cell, at that height (m)
    std::vector<std::int8_t> cells;                      ///< 0 free, 100 occupied, -1 unknown
};

/// A landmark where the picture shows it.
struct ViewPoint {
    Eigen::Vector2f px;       ///< of the picture as it is sent
    float depth_m = 0.0F;     ///< in the camera
    std::int32_t plane = -1;  ///< -1 for none
};

/// What the left camera sees, made small.
struct ViewPicture {
    int width = 0;
    int height = 0;
    std::vector<std::uint8_t> pixels;  ///< grey, row by row
    std::vector<ViewPoint> points;
};

/// What has come since the last one was taken: a stamp says that the value beside it is new.
struct ViewSnapshot {
    Timestamp begin;                ///< of the first frame of all
    std::vector<ViewState> states;  ///< oldest first
    std::optional<Timestamp> mesh_stamp;
    ViewMesh mesh;
    std::optional<Timestamp> picture_stamp;
    ViewPicture picture;
    std::optional<Timestamp> calibration_stamp;
    CalibrationEstimate calibration;

    /// Keeps the capacities.
    void clear() {
        states.clear();
        mesh_stamp.reset();
        picture_stamp.reset();
        calibration_stamp.reset();
    }
};

}  // namespace facet
