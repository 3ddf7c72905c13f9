// SPDX-License-Identifier: BSD-2-Clause
// Who is shown a flight, frame by frame.
#pragma once

#include <algorithm>
#include <functional>

#include "app/view/view_snapshot.h"

namespace facet {

/// Called on the estimator's thread: must neither wait nor use the heap after its first calls.
class FlightViewer {
public:
    static constexpr std::size_t kMaxFaces = 8192;   ///< of a mesh; more are not shown
    static constexpr std::size_t kMaxPlanes = 64;    ///< likewise
    static constexpr std::size_t kMaxPoints = 1024;  ///< of a picture; more are not shown
    static constexpr std::size_t kMaxCells = 16384;  ///< of a grid
    static constexpr int kMaxPictureSide = 480;      ///< (px)

    virtual ~FlightViewer() = default;

    /// Whether it takes a picture of a frame with this stamp.
    /// @param has_points  it will have some: those of a keyframe
    virtual bool wants_picture(Timestamp stamp, bool has_points) const = 0;
    /// Whether it takes the calibration, whose standard deviations take time.
    virtual bool wants_calibration() const = 0;

    /// Each fills in a value whose vectors are empty; called by offer(), on its thread, or not at all. An empty one
    /// says that there is nothing new.
    struct Fillers {
        std::function<void(ViewMesh&)> mesh{};
        std::function<void(ViewPicture&)> picture{};
        std::function<void(CalibrationEstimate&)> calibration{};
        std::function<void(std::vector<Eigen::Vector3f>&)> landmarks{};  ///< in W (m); up to kMaxLandmarks
        std::function<void(ViewGrid&)> grid{};                           ///< if one is kept
    };
    virtual void offer(const ViewState& state, const Fillers& fillers) = 0;
};

/// Room for the largest mesh or picture, so that fillers need no heap.
inline void reserve_most(ViewMesh& mesh) {
    mesh.faces.reserve(FlightViewer::kMaxFaces);
    mesh.planes.reserve(FlightViewer::kMaxPlanes);
}
inline void reserve_most(ViewPicture& picture) {
    picture.pixels.reserve(std::size_t{FlightViewer::kMaxPictureSide} * FlightViewer::kMaxPictureSide);
    picture.points.reserve(FlightViewer::kMaxPoints);
}

/// Lets a filler fill an emptied value; what is more than the most is left out.
inline void refill(const std::function<void(ViewMesh&)>& filler, ViewMesh& mesh) {
    mesh.faces.clear();
    mesh.planes.clear();
    filler(mesh);
    mesh.faces.resize(std::min(mesh.faces.size(), FlightViewer::kMaxFaces));
    mesh.planes.resize(std::min(mesh.planes.size(), FlightViewer::kMaxPlanes));
}
inline void refill(const std::function<void(ViewPicture&)>& filler, ViewPicture& picture) {
    picture.pixels.clear();
    picture.points.clear();
    filler(picture);
    picture.points.resize(std::min(picture.points.size(), FlightViewer::kMaxPoints));
}

}  // namespace facet
