// SPDX-License-Identifier: BSD-2-Clause
// The stages of one frame's work, so that whoever owns a clock can time them: the estimator itself has none.
#pragma once

#include <cstdint>

namespace facet {

enum class Stage : std::uint8_t {
    kPropagation,      ///< inertial integration and prediction
    kTracking,         ///< front-end, every frame
    kFrameUpdate,      ///< state of a frame between keyframes, from its image
    kTriangulation,    ///< landmarks from the current poses, and outlier tests
    kLinearization,    ///< factors, landmark elimination
    kSolve,            ///< reduced system
    kMarginalization,  ///< oldest keyframe into the prior
    kLandmarks,        ///< snapshot of the landmarks for the mesh
    kMesh,             ///< mesher, outside the estimator, at keyframes
    kPlanes,           ///< plane finder, likewise
    kDepth,            ///< semi-dense depth and its rays in the grid, likewise, at the frames after a keyframe
    kPlaces,           ///< memory of places, likewise
    kCount
};

constexpr const char* to_string(Stage s) {
    switch (s) {
        case Stage::kPropagation: return "propagation";
        case Stage::kTracking: return "tracking";
        case Stage::kFrameUpdate: return "frame_update";
        case Stage::kTriangulation: return "triangulation";
        case Stage::kLinearization: return "linearization";
        case Stage::kSolve: return "solve";
        case Stage::kMarginalization: return "marginalization";
        case Stage::kLandmarks: return "landmarks";
        case Stage::kMesh: return "mesh";
        case Stage::kPlanes: return "planes";
        case Stage::kDepth: return "depth";
        case Stage::kPlaces: return "places";
        case Stage::kCount: break;
    }
    return "?";
}

/// Notified when a stage begins and ends. Stages do not nest; one may run several times in a frame (times add up).
class StageObserver {
public:
    virtual ~StageObserver() = default;
    virtual void begin(Stage stage) = 0;
    virtual void end(Stage stage) = 0;
};

}  // namespace facet
