// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/plane_surface.h"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <utility>

#include "app/support/input_error.h"
#include "platform/base/angle.h"

namespace facet {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kLargest_m = 1000.0;

Eigen::AlignedBox2d box_of(const PlaneOutline& outline) {
    Eigen::AlignedBox2d box;
    for (const auto& line : outline.lines) {
        for (const Vector2d& corner : line) {
            box.extend(corner);
        }
    }
    return box;
}

/// Where the lines cross the level b, in order of a.
std::vector<double> crossings(const PlaneOutline& outline, double b) {
    std::vector<double> at;
    for (const auto& line : outline.lines) {
        for (std::size_t i = 0; i < line.size(); ++i) {
            const Vector2d& p = line[i];
            const Vector2d& q = line[(i + 1) % line.size()];
            if ((p.y() < b) != (q.y() < b)) {
                at.push_back(p.x() + (b - p.y()) / (q.y() - p.y()) * (q.x() - p.x()));
            }
        }
    }
    std::sort(at.begin(), at.end());
    return at;
}

}  // namespace

std::vector<Vector3d> fill(const PlaneOutline& outline) {
    std::vector<Vector3d> centres;
    const Eigen::AlignedBox2d box = box_of(outline);
    if (box.isEmpty()) {
        return centres;
    }
    const int rows = static_cast<int>(box.sizes().y() / kSurfaceSquare_m) + 1;
    for (int row = 0; row < rows; ++row) {
        const double b = box.min().y() + (row + 0.5) * kSurfaceSquare_m;
        const std::vector<double> at = crossings(outline, b);
        for (std::size_t i = 0; i + 1 < at.size(); i += 2) {
            const double first = std::ceil((at[i] - box.min().x()) / kSurfaceSquare_m - 0.5);
            const double last = std::ceil((at[i + 1] - box.min().x()) / kSurfaceSquare_m - 0.5);
            for (double column = first; column < last; ++column) {
                const double a = box.min().x() + (column + 0.5) * kSurfaceSquare_m;
                centres.emplace_back(outline.origin + a * outline.axes[0] + b * outline.axes[1]);
            }
        }
    }
    return centres;
}

std::optional<PlaneSurfaces> load_surfaces(const std::string& path) {
    if (!std::filesystem::exists(path)) {
        return std::nullopt;
    }
    PlaneSurfaces surfaces;
    const std::vector<EvalPlane> planes = load_planes(path);
    for (const EvalPlane& plane : planes) {
        if (!plane.id.has_value()) {
            continue;
        }
        const Eigen::AlignedBox2d box = box_of(plane.outline);
        if (!box.isEmpty() && box.sizes().maxCoeff() > kLargest_m) {
            throw InputError(fmt::format("{}: plane {} is larger than {:g} m", path, *plane.id, kLargest_m));
        }
        surfaces[static_cast<std::uint32_t>(*plane.id)] = {plane.normal, fill(plane.outline),
                                                           !plane.outline.lines.empty(), plane.claim};
    }
    return surfaces.empty() && !planes.empty() ? std::nullopt : std::optional(std::move(surfaces));
}

PlaneError error_of(const PlaneClaim& claim, const EvalPlane& truth, const Se3& T_true_est) {
    const Vector3d n = T_true_est.q * claim.axes[0].cross(claim.axes[1]);
    PlaneError error;
    const double offset = truth.normal.dot(T_true_est * claim.origin) - truth.distance;
    error.angle_deg = std::atan2(n.cross(truth.normal).norm(), n.dot(truth.normal)) / kRadPerDeg;
    error.offset_m = std::abs(offset);
    error.sigmas[0] = offset / claim.sigma_m;
    for (int k = 0; k < 2; ++k) {
        const Vector3d axis = T_true_est.q * claim.axes[static_cast<std::size_t>(k)];
        error.sigmas[k + 1] = std::asin(std::clamp(truth.normal.dot(axis), -1.0, 1.0)) / claim.sigma_turn[k];
    }
    return error;
}

PlaneSurface disc_of(const PlaneRow& row, double least_m2) {
    constexpr int kCorners = 64;
    const double radius = std::sqrt(std::max(row.area_m2, least_m2) / std::numbers::pi);
    PlaneOutline outline;
    outline.origin = row.centroid;
    outline.axes[0] = row.normal.unitOrthogonal();
    outline.axes[1] = row.normal.cross(outline.axes[0]);
    auto& line = outline.lines.emplace_back();
    for (int i = 0; i < kCorners; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / kCorners;
        line.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
    }
    return {row.normal, fill(outline)};
}

}  // namespace facet
