// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/sim/truth.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>
#include <utility>

#include "app/support/ply_writer.h"
#include "estimator/values/planes.h"
#include "platform/base/angle.h"

namespace facet::sim {
namespace {

using Eigen::Vector3d;

constexpr double kCell_m = 0.1;
constexpr double kSameDistance_m = 0.025;
constexpr double kTouch_m = 0.05;
const double kSameCosine = std::cos(0.5 * kRadPerDeg);
const double kLevelSine = std::sin(3.0 * kRadPerDeg);  // of the tilt that floors and walls may have

/// Segments around a circle of radius r with the wanted sagitta, r (1 - cos(pi / n)).
int segments(double radius, double sagitta) {
    const double half = std::acos(1.0 - std::min(0.5, sagitta / radius));
    return std::max(8, static_cast<int>(std::ceil(std::numbers::pi / half)));
}

void add_grid(TriangleMesh& mesh, const SurfaceShape& s, int columns, int rows) {
    const auto first = static_cast<int>(mesh.vertices.size());
    for (int j = 0; j <= rows; ++j) {
        for (int i = 0; i <= columns; ++i) {
            mesh.vertices.push_back(
                surface_point(s, static_cast<double>(i) / columns, static_cast<double>(j) / rows).cast<float>());
        }
    }
    for (int j = 0; j < rows; ++j) {
        for (int i = 0; i < columns; ++i) {
            const int a = first + j * (columns + 1) + i;
            const int d = a + columns + 1;
            mesh.triangles.push_back({a, a + 1, d + 1});
            mesh.triangles.push_back({a, d + 1, d});
        }
    }
}

void add_disk(TriangleMesh& mesh, const SurfaceShape& s, double sagitta) {
    const int count = segments(0.5 * s.edge_u.norm(), sagitta);
    const auto first = static_cast<int>(mesh.vertices.size());
    for (int i = 0; i < count; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / count;
        mesh.vertices.push_back(
            surface_point(s, 0.5 + 0.5 * std::cos(angle), 0.5 + 0.5 * std::sin(angle)).cast<float>());
        if (i >= 2) {
            mesh.triangles.push_back({first, first + i - 1, first + i});
        }
    }
}

void add_triangle(TriangleMesh& mesh, const SurfaceShape& s) {
    const auto first = static_cast<int>(mesh.vertices.size());
    for (const Vector3d& p : {s.origin, Vector3d(s.origin + s.edge_u), Vector3d(s.origin + s.edge_v)}) {
        mesh.vertices.push_back(p.cast<float>());
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
}

/// Cells of about kCell_m across a surface.
std::pair<int, int> cells(const SurfaceShape& s) {
    const Eigen::Vector2d extent = surface_extent(s);
    return {static_cast<int>(std::ceil(extent.x() / kCell_m)), static_cast<int>(std::ceil(extent.y() / kCell_m))};
}

/// Seen area of every surface.
std::vector<double> seen_areas(const Scene& scene, std::span<const CoarseHit> hits) {
    std::set<std::pair<int, int>> seen;
    for (const CoarseHit& hit : hits) {
        if (hit.surface < 0) {
            continue;
        }
        const auto [columns, rows] = cells(scene.shapes()[static_cast<std::size_t>(hit.surface)]);
        const int i = std::clamp(static_cast<int>(hit.u * static_cast<float>(columns)), 0, columns - 1);
        const int j = std::clamp(static_cast<int>(hit.v * static_cast<float>(rows)), 0, rows - 1);
        seen.emplace(hit.surface, j * columns + i);
    }
    std::vector<double> areas(scene.shapes().size(), 0.0);
    for (const auto& [surface, cell] : seen) {
        const SurfaceShape& shape = scene.shapes()[static_cast<std::size_t>(surface)];
        const auto [columns, rows] = cells(shape);
        double& area = areas[static_cast<std::size_t>(surface)];
        area = std::min(area + surface_extent(shape).prod() / (columns * rows), surface_area(shape));
    }
    return areas;
}

TruePlane plane_of(const Surface& surface, double seen_area) {
    const SurfaceShape& s = surface.shape;
    TruePlane plane;
    plane.name = surface.name;
    plane.normal = surface_normal(s, 0.5, 0.5);
    plane.distance = plane.normal.dot(s.origin);
    plane.area = surface_area(s);
    plane.seen_area = seen_area;
    plane.centroid = surface_point(s, 0.5, 0.5);
    plane.low = plane.high = s.origin;
    for (const auto& [u, v] : {std::pair{1.0, 0.0}, std::pair{0.0, 1.0}, std::pair{1.0, 1.0}}) {
        plane.low = plane.low.cwiseMin(surface_point(s, u, v));
        plane.high = plane.high.cwiseMax(surface_point(s, u, v));
    }
    return plane;
}

bool same_plane(const TruePlane& a, const TruePlane& b) {
    const Vector3d gap = (a.low - b.high).cwiseMax(b.low - a.high);
    return a.normal.dot(b.normal) > kSameCosine && std::abs(a.normal.dot(b.centroid) - a.distance) < kSameDistance_m &&
           gap.maxCoeff() < kTouch_m;
}

nlohmann::json to_json(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Status save(const std::string& path, const std::string& text, std::string& failed) {
    std::ofstream file(path, std::ios::binary);
    file << text;
    file.close();
    if (!file) {
        failed = path;
        return Status::kIo;
    }
    return Status::kOk;
}

const char* kind_of(const Vector3d& normal) {
    if (normal.head<2>().norm() < kLevelSine) {
        return to_string(PlaneKind::kHorizontal);
    }
    return std::abs(normal.z()) < kLevelSine ? to_string(PlaneKind::kVertical) : "slanted";
}

/// The format of mesh/README.md.
std::string planes_json(std::span<const TruePlane> planes) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const TruePlane& p : planes) {
        nlohmann::ordered_json entry;
        entry["id"] = list.size();
        entry["normal"] = to_json(p.normal);
        entry["distance"] = p.distance;
        entry["kind"] = kind_of(p.normal);
        entry["name"] = p.name;
        entry["centroid"] = to_json(p.centroid);
        entry["min"] = to_json(p.low);
        entry["max"] = to_json(p.high);
        entry["area"] = p.area;
        entry["seen_area"] = p.seen_area;
        list.push_back(entry);
    }
    return list.dump(1) + "\n";
}

}  // namespace

TriangleMesh tessellate(const Scene& scene, double sagitta_m) {
    TriangleMesh mesh;
    for (const SurfaceShape& s : scene.shapes()) {
        const int around = is_planar(s.shape) ? 0 : segments(s.radius, sagitta_m);
        switch (s.shape) {
            case Shape::kRectangle: add_grid(mesh, s, 1, 1); break;
            case Shape::kTriangle: add_triangle(mesh, s); break;
            case Shape::kDisk: add_disk(mesh, s, sagitta_m); break;
            case Shape::kSphere: add_grid(mesh, s, around, std::max(4, around / 2)); break;
            case Shape::kCylinder: add_grid(mesh, s, around, 1); break;
        }
    }
    return mesh;
}

std::vector<TruePlane> true_planes(const Scene& scene, std::span<const CoarseHit> hits, double min_area) {
    const std::vector<double> seen = seen_areas(scene, hits);
    std::vector<TruePlane> parts;
    for (std::size_t i = 0; i < scene.surfaces().size(); ++i) {
        const Shape shape = scene.surfaces()[i].shape.shape;
        if (shape == Shape::kRectangle || shape == Shape::kDisk) {
            parts.push_back(plane_of(scene.surfaces()[i], seen[i]));
        }
    }
    std::stable_sort(parts.begin(), parts.end(),
                     [](const TruePlane& a, const TruePlane& b) { return a.area > b.area; });
    std::vector<TruePlane> planes;
    for (const TruePlane& part : parts) {
        const auto host =
            std::find_if(planes.begin(), planes.end(), [&](const TruePlane& p) { return same_plane(p, part); });
        if (host == planes.end()) {
            planes.push_back(part);
            continue;
        }
        host->centroid = (host->area * host->centroid + part.area * part.centroid) / (host->area + part.area);
        host->area += part.area;
        host->seen_area += part.seen_area;
        host->low = host->low.cwiseMin(part.low);
        host->high = host->high.cwiseMax(part.high);
    }
    std::erase_if(planes, [min_area](const TruePlane& p) { return p.area < min_area; });
    std::stable_sort(planes.begin(), planes.end(),
                     [](const TruePlane& a, const TruePlane& b) { return a.seen_area > b.seen_area; });
    return planes;
}

Status write_truth(const std::string& out, const Scene& scene, std::span<const CoarseHit> hits,
                   const std::string& meta_json, std::string& failed) {
    const std::string folder = out + "/truth";
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    const TriangleMesh mesh = tessellate(scene);
    failed = folder + "/scene.ply";
    FACET_TRY(write_ply(failed, "true geometry of the simulated scene, world frame", mesh.vertices, mesh.triangles));
    failed.clear();
    FACET_TRY(save(folder + "/planes.json", planes_json(true_planes(scene, hits)), failed));
    return save(folder + "/meta.json", meta_json, failed);
}

}  // namespace facet::sim
