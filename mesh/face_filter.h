// SPDX-License-Identifier: BSD-2-Clause
// Which triangles of the image are faces of a surface: geometric tests on the lifted triangle.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

#include "mesh/delaunay.h"
#include "mesh/mesh_config.h"
#include "platform/base/image_view.h"

namespace facet {

/// Why a triangle is no face, in the order of the tests.
enum class FaceVerdict : std::uint8_t {
    kAccepted,
    kLandmark,    ///< a corner is too far, too uncertain or contradicts its sightings
    kSideLength,  ///< a side is too long
    kSideRatio,   ///< too thin
    kElongation,  ///< stretched along the ray
    kGrazing,     ///< seen edge on
    kDepthStep,   ///< a side jumps in depth, beyond its uncertainty
    kGradient,    ///< a side jumps in depth across an edge of the image
    kLonely,      ///< large and not in one plane with its neighbours, or without neighbours
    kCount
};

constexpr const char* to_string(FaceVerdict v) {
    switch (v) {
        case FaceVerdict::kAccepted: return "accepted";
        case FaceVerdict::kLandmark: return "landmark";
        case FaceVerdict::kSideLength: return "side_length";
        case FaceVerdict::kSideRatio: return "side_ratio";
        case FaceVerdict::kElongation: return "elongation";
        case FaceVerdict::kGrazing: return "grazing";
        case FaceVerdict::kDepthStep: return "depth_step";
        case FaceVerdict::kGradient: return "gradient";
        case FaceVerdict::kLonely: return "lonely";
        case FaceVerdict::kCount: break;
    }
    return "?";
}

/// A corner of a triangle in the camera that sees it.
struct MeshPoint {
    Eigen::Vector3d p_C = Eigen::Vector3d::Zero();    ///< (m)
    double depth_sigma_m = 0.0;                       ///< along the ray
    Eigen::Vector2f pixel = Eigen::Vector2f::Zero();  ///< distorted (px)
    bool is_usable = false;                           ///< may be a corner of a face
};

/// Judges all triangles of one image.
///   side ratio   shortest / longest side >= min_side_ratio                                  [Rosinol19]
///   elongation   extent across the mean ray / extent along it >= min_elongation              [Rosinol19]
///   grazing      angle(normal, ray to the centroid) <= max_grazing_deg
///   depth step   for each side: gap = |z_i - z_j|, lateral = min(z_i, z_j) |xy_i - xy_j|; if gap exceeds kStepSigmas
///                of its standard deviations, gap / lateral <= max_step_slope, or <= gradient_step_slope if the image
///                changes by kStrongGradient within two pixels somewhere between the corners
/// A triangle that fails only a step test is kept if at least two neighbours lie in its plane within coplanar_m: then
/// it is part of a slanted surface. The same applies to one with a side between max_side_m and max_flat_side_m: on a
/// bare wall points are far apart. A triangle with a side beyond kLonelySide_m needs lonely_neighbours such neighbours
/// in any case: three points far apart say little about what is between them. Finally, a triangle none of whose
/// neighbours passed is left out (unless lonely_neighbours is 0): at the edge of a surface these are mostly bridges to
/// the next one.
/// Reentrant. No heap.
/// @param image     left image, or empty: then the gradient test is left out
/// @param verdicts  as many as triangles; filled
void filter_faces(const MeshConfig& config, std::span<const Triangle> triangles, std::span<const MeshPoint> points,
                  const ImageView& image, std::span<FaceVerdict> verdicts);

}  // namespace facet
