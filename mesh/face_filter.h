// SPDX-License-Identifier: BSD-2-Clause
// Which triangles of the image are faces of a surface: geometric tests on the lifted triangle.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

#include "mesh/delaunay.h"
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

/// By which triangles are judged; see filter_faces().
struct FaceRules {
    double min_side_ratio = 0.1;       ///< [Rosinol19] has 0.2
    double min_elongation = 0.2;       ///< that of [Rosinol19]
    double max_side_m = 1.2;           ///< [Rosinol19] has 2 m for all faces
    double max_flat_side_m = 3.0;      ///< with two neighbours in its plane, as on bare walls; at least max_side_m
    double max_grazing_deg = 80.0;     ///< in (0, 90]
    double max_step_slope = 2.0;       ///< depth step over lateral distance along a side
    double gradient_step_slope = 0.8;  ///< the same of a side that crosses a strong image gradient
    double coplanar_m = 0.03;          ///< distance of a neighbour's far corner from the face's plane
    int lonely_neighbours = 1;         ///< in its plane that a large face needs
};

/// Judges all triangles of one image.
///   side ratio   shortest / longest side >= min_side_ratio
///   elongation   extent across the mean ray / extent along it >= min_elongation
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
void filter_faces(const FaceRules& rules, std::span<const Triangle> triangles, std::span<const MeshPoint> points,
                  const ImageView& image, std::span<FaceVerdict> verdicts);

}  // namespace facet
