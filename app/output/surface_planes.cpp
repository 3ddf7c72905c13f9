// SPDX-License-Identifier: BSD-2-Clause
#include "app/output/surface_planes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace facet {
namespace {

constexpr float kCell = 0.1F;         // m
constexpr float kOnPlane = 0.03F;     // m
constexpr float kLeastFacing = 0.9F;  // cosine
constexpr int kMostSamples = 64;      // along a side of a face

std::array<int, 3> cell_of(const Eigen::Vector3f& p) {
    const Eigen::Vector3i cell = (p / kCell).array().floor().matrix().cast<int>();
    return {cell.x(), cell.y(), cell.z()};
}

}  // namespace

SurfacePlanes::SurfacePlanes(std::span<const DepartedFace> faces, const PlaneNames& names) {
    for (const DepartedFace& face : faces) {
        const Eigen::Vector3f along = face.p_W[1] - face.p_W[0];
        const Eigen::Vector3f across = face.p_W[2] - face.p_W[0];
        const Eigen::Vector3f area = 0.5F * along.cross(across);
        if (!face.plane.valid() || !area.allFinite() || !(area.norm() > 0.0F)) {
            continue;
        }
        Plane& plane = planes_[static_cast<std::int32_t>(names.now(face.plane).value)];
        const float sign = plane.normal_W.dot(area) < 0.0F ? -1.0F : 1.0F;
        plane.normal_W += sign * area;
        plane.area_m2 += area.norm();
        const float longest = std::max({along.norm(), across.norm(), (across - along).norm()});
        const int steps = std::clamp(static_cast<int>(2.0F * longest / kCell) + 1, 1, kMostSamples);
        for (int i = 0; i <= steps; ++i) {
            for (int j = 0; i + j <= steps; ++j) {
                const auto n = static_cast<float>(steps);
                plane.cells.insert(
                    cell_of(face.p_W[0] + static_cast<float>(i) / n * along + static_cast<float>(j) / n * across));
            }
        }
    }
    for (auto& [id, plane] : planes_) {
        plane.normal_W.normalize();
    }
    for (const DepartedFace& face : faces) {
        const auto at =
            face.plane.valid() ? planes_.find(static_cast<std::int32_t>(names.now(face.plane).value)) : planes_.end();
        if (at == planes_.end()) {
            continue;
        }
        Plane& plane = at->second;
        const float area = 0.5F * (face.p_W[1] - face.p_W[0]).cross(face.p_W[2] - face.p_W[0]).norm();
        const float distance = plane.normal_W.dot(face.p_W[0] + face.p_W[1] + face.p_W[2]) / 3.0F;
        plane.distance_m += std::isfinite(area * distance) ? area / plane.area_m2 * distance : 0.0F;
    }
}

std::int32_t SurfacePlanes::plane_of(const Eigen::Vector3f& p_W, const Eigen::Vector3f& normal_W) const {
    std::int32_t found = -1;
    float nearest = kOnPlane;
    for (const auto& [id, plane] : planes_) {
        const float off = std::abs(plane.normal_W.dot(p_W) - plane.distance_m);
        if (!(off < nearest) || std::abs(plane.normal_W.dot(normal_W)) < kLeastFacing) {
            continue;
        }
        const std::array<int, 3> cell = cell_of(p_W);
        bool is_near = false;
        for (int i = 0; i < 27 && !is_near; ++i) {
            is_near = plane.cells.contains({cell[0] + i % 3 - 1, cell[1] + i / 3 % 3 - 1, cell[2] + i / 9 - 1});
        }
        if (is_near) {
            found = id;
            nearest = off;
        }
    }
    return found;
}

}  // namespace facet
