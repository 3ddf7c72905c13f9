// SPDX-License-Identifier: BSD-2-Clause
// Assembly of scenes: shapes, materials and their textures.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "app/lab/sim/scene.h"
#include "platform/base/assert.h"

namespace facet::sim {
namespace {

using Eigen::Vector3d;

/// Large tiles get all texels, so that one is about 2 mm everywhere.
bool is_large(const Material& m) { return m.tile_m > 1.25; }

}  // namespace

MaterialId SceneBuilder::material(const Material& m) {
    materials_.push_back(m);
    return static_cast<MaterialId>(materials_.size()) - 1;
}

void SceneBuilder::add(std::string name, MaterialId m, const SurfaceShape& shape) {
    FACET_ASSERT(m >= 0 && m < static_cast<int>(materials_.size()));
    Surface surface;
    surface.shape = shape;
    surface.name = std::move(name);
    surface.material = m;
    scene_.surfaces_.push_back(std::move(surface));
}

void SceneBuilder::rectangle(std::string name, MaterialId m, const Vector3d& origin, const Vector3d& edge_u,
                             const Vector3d& edge_v) {
    FACET_ASSERT(std::abs(edge_u.dot(edge_v)) < 1e-9);
    add(std::move(name), m, {Shape::kRectangle, origin, edge_u, edge_v, 0.0});
}

void SceneBuilder::box(const std::string& name, MaterialId sides, MaterialId top, const Vector3d& centre,
                       const Vector3d& size, double yaw_rad) {
    const Eigen::Matrix3d r = Eigen::AngleAxisd(yaw_rad, Vector3d::UnitZ()).toRotationMatrix();
    const Vector3d x = r.col(0) * size.x();
    const Vector3d y = r.col(1) * size.y();
    const Vector3d z = r.col(2) * size.z();
    const Vector3d low = centre - 0.5 * (x + y + z);
    const Vector3d high = centre + 0.5 * (x + y + z);
    rectangle(name + ".top", top, low + z, x, y);
    rectangle(name + ".bottom", sides, low, y, x);
    rectangle(name + ".front", sides, low + x, y, z);
    rectangle(name + ".back", sides, low + y, -y, z);
    rectangle(name + ".left", sides, high - z, -x, z);
    rectangle(name + ".right", sides, low, x, z);
}

void SceneBuilder::cylinder(const std::string& name, MaterialId m, const Vector3d& base, const Vector3d& axis,
                            double radius, bool caps) {
    const Vector3d side = axis.unitOrthogonal();
    add(name + ".side", m, {Shape::kCylinder, base, side, axis, radius});
    if (caps) {
        const Vector3d other = axis.normalized().cross(side);
        const Vector3d corner = -radius * (side + other);
        add(name + ".top", m, {Shape::kDisk, base + axis + corner, 2.0 * radius * side, 2.0 * radius * other, 0.0});
        add(name + ".bottom", m, {Shape::kDisk, base + corner, 2.0 * radius * other, 2.0 * radius * side, 0.0});
    }
}

void SceneBuilder::sphere(const std::string& name, MaterialId m, const Vector3d& centre, double radius) {
    add(name, m, {Shape::kSphere, centre, Vector3d::Zero(), Vector3d::Zero(), radius});
}

void SceneBuilder::mesh(const std::string& name, MaterialId m, const Mesh& mesh) {
    const auto first = static_cast<std::uint32_t>(vertices_.size());
    vertices_.insert(vertices_.end(), mesh.vertices.begin(), mesh.vertices.end());
    normals_.resize(vertices_.size(), Vector3d::Zero());
    for (const Eigen::Vector3i& t : mesh.triangles) {
        const Vector3d& a = mesh.vertices[t[0]];
        const Vector3d u = mesh.vertices[t[1]] - a;
        const Vector3d v = mesh.vertices[t[2]] - a;
        add(name, m, {Shape::kTriangle, a, u, v, 0.0});
        Surface& surface = scene_.surfaces_.back();
        for (int i = 0; i < 3; ++i) {
            surface.corners[i] = first + static_cast<std::uint32_t>(t[i]);
            surface.texture_m[i] = mesh.texture_m[t[i]];
            normals_[surface.corners[i]] += u.cross(v);
        }
    }
}

void SceneBuilder::lamp(const std::string& name, MaterialId m, const Vector3d& centre, const Vector3d& half_u,
                        const Vector3d& half_v, double power) {
    rectangle(name, m, centre - half_u - half_v, 2.0 * half_u, 2.0 * half_v);
    lights_.push_back({centre, half_u, half_v, half_u.cross(half_v).normalized(), power});
}

void SceneBuilder::bake_textures(const SceneDetail& detail) {
    scene_.textures_.push_back(
        bake_pattern(Pattern::kBlotches, 5, std::max(detail.texture_size / 4, 16), detail.threads));
    for (const Material& m : materials_) {
        const int size = is_large(m) ? detail.texture_size : std::max(detail.texture_size / 2, 16);
        scene_.textures_.push_back(bake_pattern(m.pattern, m.seed, size, detail.threads));
    }
}

Scene::Look SceneBuilder::look_of(const Surface& surface, double contrast) const {
    const Material& m = materials_[surface.material];
    const auto kept = static_cast<float>(contrast);
    Scene::Look look{};
    look.texture = static_cast<std::uint16_t>(surface.material + 1);
    look.albedo_offset = m.dark + 0.5F * (1.0F - kept) * (m.bright - m.dark);
    look.albedo_slope = kept * (m.bright - m.dark) / 255.0F;
    look.blotches = kept * m.blotches;
    look.emission = m.emission;
    const Eigen::Vector2d extent = surface_extent(surface.shape);
    Eigen::Vector3d s(0.0, 1.0, 0.0);
    Eigen::Vector3d t(0.0, 0.0, 1.0);
    double per_metre = 1.0 / std::sqrt(extent.prod());
    if (surface.shape.shape == Shape::kTriangle) {
        const Eigen::Vector2d* c = surface.texture_m;
        s = Vector3d(c[0].x(), c[1].x() - c[0].x(), c[2].x() - c[0].x()) / m.tile_m;
        t = Vector3d(c[0].y(), c[1].y() - c[0].y(), c[2].y() - c[0].y()) / m.tile_m;
        per_metre = 1.0 / m.tile_m;
    } else if (m.tile_m > 0.0) {
        // A start that differs from surface to surface, so that equal boxes do not look alike.
        const Vector3d& o = surface.shape.origin;
        const double shift = o.dot(Vector3d(0.37, 0.61, 0.23)) + 3.0;
        s = {shift, extent.x() / m.tile_m, 0.0};
        t = {0.7 * shift, 0.0, extent.y() / m.tile_m};
        if (!is_planar(surface.shape.shape)) {
            s[1] = std::max(1.0, std::round(s[1]));  // whole repeats around: no seam
        }
        per_metre = std::max(s[1] / extent.x(), 1.0 / m.tile_m);
    }
    for (int i = 0; i < 3; ++i) {
        look.s[i] = static_cast<float>(s[i]);
        look.t[i] = static_cast<float>(t[i]);
    }
    look.texels_per_metre = static_cast<float>(per_metre);
    return look;
}

Scene SceneBuilder::build(const SceneDetail& detail) {
    for (const Surface& surface : scene_.surfaces_) {
        scene_.shapes_.push_back(surface.shape);
    }
    scene_.bvh_.build(scene_.shapes_);
    bake_textures(detail);
    for (const Primitive& primitive : scene_.bvh_.primitives()) {
        scene_.looks_.push_back(look_of(scene_.surfaces_[primitive.surface], detail.contrast));
    }
    for (Vector3d& normal : normals_) {
        normal.normalize();
    }
    scene_.bake_light(lights_, ambient_, vertices_, normals_, detail);
    return std::move(scene_);
}

std::span<const std::string_view> scene_names() {
    static constexpr std::array<std::string_view, 3> kNames{"room", "hall", "building"};
    return kNames;
}

Scene make_scene(std::string_view name, const SceneDetail& detail, std::uint64_t seed) {
    if (name == "building") {
        return make_building(detail, seed);
    }
    FACET_ASSERT(name == "room" || name == "hall");
    return name == "room" ? make_room(detail) : make_hall(detail);
}

}  // namespace facet::sim
