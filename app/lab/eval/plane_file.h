// SPDX-License-Identifier: BSD-2-Clause
// Reads planes.json: the true planes of a scene, or those that a run has found.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace facet {

/// Where a plane has surface: closed lines of corners [a, b], which stand for origin + a axes[0] + b axes[1] (m). A
/// point is surface if an odd number of them is around it.
struct PlaneOutline {
    Eigen::Vector3d origin = Eigen::Vector3d::Zero();
    std::array<Eigen::Vector3d, 2> axes{Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY()};
    std::vector<std::vector<Eigen::Vector2d>> lines;  ///< boundaries and holes of all regions
};

/// How well a run says that it knows a plane: standard deviations of its place at the origin, and of the turn that
/// lifts points along each axis.
struct PlaneClaim {
    Eigen::Vector3d origin = Eigen::Vector3d::Zero();
    std::array<Eigen::Vector3d, 2> axes{Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY()};
    double sigma_m = 0.0;
    Eigen::Vector2d sigma_turn = Eigen::Vector2d::Zero();  ///< (rad)
};

/// A plane normal . x = distance to compare with.
struct EvalPlane {
    std::string name;  ///< "plane ID" if the file has only an id; empty if it has neither
    Eigen::Vector3d normal;
    double distance = 0.0;                  ///< of the plane from the world's origin along its normal (m)
    double seen_m2 = 0.0;                   ///< area of its surface seen in the whole run; 0 if the file does not say
    Eigen::AlignedBox3d box = kEverywhere;  ///< around its surface; everywhere if the file does not say
    std::optional<std::uint64_t> id{};      ///< none if the file does not say
    PlaneOutline outline{};                 ///< no lines if the file has no regions
    std::optional<PlaneClaim> claim{};      ///< none if the file does not say

    static const Eigen::AlignedBox3d kEverywhere;
};

/// Reads planes.json in the format of mesh/README.md, whether the simulator or a run wrote it, and in the older form of
/// true planes: an object whose member "planes" is the array, with "offset" in the place of "distance".
/// @return the planes in the order of the file; none if there is no such file
/// Throws InputError with the file, and the entry by its place from 0, if the file cannot be used.
std::vector<EvalPlane> load_planes(const std::string& path);

}  // namespace facet
