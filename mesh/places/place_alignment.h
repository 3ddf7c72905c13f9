// SPDX-License-Identifier: BSD-2-Clause
// A place that was recognised, found in the image to a fraction of a pixel.
#pragma once

#include "mesh/places/place_pose.h"

namespace facet {

/// Refines the pose of a view in a place: each of the place's points is looked for in the image where the pose has it,
/// by aligning its patch (Lucas-Kanade in the upright square, two unknowns, brightness and contrast free), and the pose
/// is fitted to where they are (SightingFit), and to the depths of the view's own points that match them. Reentrant.
/// Deterministic. No heap.
/// @param pyramid  of the view's image, kPlaceLevels or more
/// @param camera   with its lens as it is known now
/// @param matches  of the view's points and the place's
/// @param pose     of find_pose(); its matches are then the points looked for, its inliers those found that agree
/// @return kDegenerate if fewer than kMinInliers agree, or less than half of those looked for (pose untouched)
Status align_place(const ImagePyramid& pyramid, const CameraModel& camera, const PlaceView& seen,
                   const PlaceView& known, const PointMatches& matches, PlacePose& pose);

}  // namespace facet
