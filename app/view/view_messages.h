// SPDX-License-Identifier: BSD-2-Clause
// What is sent to browsers. Text messages are JSON; binary ones are little-endian and begin with an int32 that names
// their kind.
#pragma once

#include "app/view/live_view.h"
#include "app/view/viewer.h"

namespace facet {

enum class ViewMessageKind : std::int32_t {
    kMesh = 0,  ///< for each face nine float32, its corners in W (m), and its plane as int32
    kPicture =
        1,  ///< int32 width, height, number of points; for each float32 x, y (px), depth (m), int32 plane; pixels
    kSurface = 2,  ///< int32 number of the surface: with another one, all pieces before are gone; see LiveSurface
};

/// First of all: the left camera's pose on the body, its principal point as tangents.
SharedMessage hello_message(const StereoRig& rig);
/// @param begin  time 0
SharedMessage frame_message(const ViewState& state, Timestamp begin);
SharedMessage mesh_message(const std::vector<ViewFace>& faces);
SharedMessage picture_message(const ViewPicture& picture);
/// @param pieces  of LiveSurface
SharedMessage surface_message(std::uint32_t surface, const std::string& pieces);

}  // namespace facet
