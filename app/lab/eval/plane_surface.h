// SPDX-License-Identifier: BSD-2-Clause
// Where the planes of a run have surface.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "app/lab/eval/plane_file.h"
#include "app/lab/eval/plane_rows.h"
#include "estimator/geometry/se3.h"

namespace facet {

/// Edge of the squares that surface is divided into (m).
inline constexpr double kSurfaceSquare_m = 0.05;

/// In the world of the estimate.
struct PlaneSurface {
    Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
    std::vector<Eigen::Vector3d> squares;  ///< their centres
    bool has_regions = true;               ///< false: where its surface is, is not known
    std::optional<PlaneClaim> claim{};
};

/// How far a plane is off at its origin, and over its reported sigma.
struct PlaneError {
    double angle_deg = 0.0;
    double offset_m = 0.0;                             ///< of the origin from the true plane
    Eigen::Vector3d sigmas = Eigen::Vector3d::Zero();  ///< of the place and of the turn along each axis, signed
};

PlaneError error_of(const PlaneClaim& claim, const EvalPlane& truth, const Se3& T_true_est);

using PlaneSurfaces = std::map<std::uint32_t, PlaneSurface>;  ///< by the plane's id

/// The planes in planes.json of a run that have an id; none if there is no such file, or no id in it. Throws InputError
/// if the file cannot be used, or a plane in it would be larger than a square kilometre.
std::optional<PlaneSurfaces> load_surfaces(const std::string& path);

/// What an outline is around.
std::vector<Eigen::Vector3d> fill(const PlaneOutline& outline);

/// For a plane of which no regions are known: a disc of the row's area, at least `least_m2`, about its centroid.
PlaneSurface disc_of(const PlaneRow& row, double least_m2);

}  // namespace facet
