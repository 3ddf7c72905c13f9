// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/sim/scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/lab/sim/parallel.h"

namespace facet::sim {
namespace {

using Eigen::Vector3d;

constexpr double kLift_m = 0.004;        // light is gathered this far above the surface
constexpr double kAmbientReach_m = 4.0;  // surroundings nearer than this darken the ambient light

/// Four rays from one point.
RayPacket fan(const Vector3d& from, const Vector3d* directions, F4 reach) {
    RayPacket r;
    r.origin = {splat(static_cast<float>(from.x())), splat(static_cast<float>(from.y())),
                splat(static_cast<float>(from.z()))};
    for (int i = 0; i < kLanes; ++i) {
        r.direction.x[i] = static_cast<float>(directions[i].x());
        r.direction.y[i] = static_cast<float>(directions[i].y());
        r.direction.z[i] = static_cast<float>(directions[i].z());
    }
    r.t = reach;
    r.primitive = I4{-1, -1, -1, -1};
    return r;
}

/// The i-th of n points of the R2 sequence in the unit square. Roberts, "The unreasonable effectiveness of quasirandom
/// sequences", 2018.
Eigen::Vector2d quasi_random(int i) {
    const double a = 0.5 + 0.7548776662466927 * i;
    const double b = 0.5 + 0.5698402909980532 * i;
    return {a - std::floor(a), b - std::floor(b)};
}

}  // namespace

/// Gathers direct light with soft shadows and ambient light with occlusion at a point with a normal.
class LightGatherer {
public:
    LightGatherer(const Bvh& bvh, std::span<const AreaLight> lights, double ambient, int samples)
        : bvh_(bvh), lights_(lights), ambient_(ambient), samples_((samples + 3) / 4 * 4) {}

    float at(const Vector3d& surface_point, const Vector3d& normal) const {
        const Vector3d p = surface_point + kLift_m * normal;
        double sum = ambient_ * openness(p, normal);
        for (const AreaLight& light : lights_) {
            sum += direct(light, p, normal);
        }
        return static_cast<float>(sum);
    }

private:
    double direct(const AreaLight& light, const Vector3d& p, const Vector3d& normal) const {
        double sum = 0.0;
        for (int first = 0; first < samples_; first += kLanes) {
            Vector3d directions[kLanes];
            double weights[kLanes];
            F4 reach = splat(0.0F);
            for (int i = 0; i < kLanes; ++i) {
                const Eigen::Vector2d q = 2.0 * quasi_random(first + i) - Eigen::Vector2d::Ones();
                const Vector3d to_light = light.centre + q.x() * light.half_u + q.y() * light.half_v - p;
                const double distance = to_light.norm();
                directions[i] = to_light / distance;
                weights[i] = std::max(0.0, directions[i].dot(normal)) *
                             std::max(0.0, -directions[i].dot(light.normal)) / (distance * distance + 0.05);
                reach[i] = static_cast<float>(distance - 2.0 * kLift_m);
            }
            if (weights[0] + weights[1] + weights[2] + weights[3] <= 0.0) {
                continue;
            }
            RayPacket rays = fan(p, directions, reach);
            bvh_.intersect(rays);
            for (int i = 0; i < kLanes; ++i) {
                sum += rays.primitive[i] < 0 ? weights[i] : 0.0;
            }
        }
        return light.power * sum / samples_;
    }

    /// Share of the cosine-weighted hemisphere that is open, near surfaces counting as half dark.
    double openness(const Vector3d& p, const Vector3d& normal) const {
        const Vector3d x = normal.unitOrthogonal();
        const Vector3d y = normal.cross(x);
        const int count = 2 * samples_;
        double sum = 0.0;
        for (int first = 0; first < count; first += kLanes) {
            Vector3d directions[kLanes];
            for (int i = 0; i < kLanes; ++i) {
                const Eigen::Vector2d q = quasi_random(first + i);
                const double radius = std::sqrt(q.x());
                const double angle = 2.0 * std::numbers::pi * q.y();
                directions[i] =
                    radius * std::cos(angle) * x + radius * std::sin(angle) * y + std::sqrt(1.0 - q.x()) * normal;
            }
            RayPacket rays = fan(p, directions, splat(static_cast<float>(kAmbientReach_m)));
            bvh_.intersect(rays);
            for (int i = 0; i < kLanes; ++i) {
                sum += std::sqrt(static_cast<double>(rays.t[i]) / kAmbientReach_m);
            }
        }
        return sum / count;
    }

    const Bvh& bvh_;
    std::span<const AreaLight> lights_;
    double ambient_;
    int samples_;
};

RayHit Scene::cast(const Vector3d& origin, const Vector3d& direction) const {
    const Vector3d directions[kLanes] = {direction, direction, direction, direction};
    RayPacket rays = fan(origin, directions, splat(RayPacket::kFar));
    bvh_.intersect(rays);
    if (rays.primitive[0] < 0) {
        return {};
    }
    const Eigen::Vector3f d = direction.cast<float>();
    const Eigen::Vector3f p = (origin + static_cast<double>(rays.t[0]) * direction).cast<float>();
    const Primitive& primitive = bvh_.primitives()[rays.primitive[0]];
    const SurfaceHit hit = locate(primitive, p.data(), d.data());
    return {static_cast<int>(primitive.surface), rays.t[0], hit.u, hit.v};
}

void Scene::shade(const RayPacket& packet, float spread, float* out) const {
    const V4 p = packet.origin + packet.t * packet.direction;
    for (int i = 0; i < kLanes; ++i) {
        if (packet.primitive[i] < 0) {
            out[i] = 0.0F;
            continue;
        }
        const float point[3] = {p.x[i], p.y[i], p.z[i]};
        const float direction[3] = {packet.direction.x[i], packet.direction.y[i], packet.direction.z[i]};
        out[i] = radiance(packet.primitive[i], point, direction, spread * packet.t[i]);
    }
}

float Scene::radiance(int primitive, const float* p, const float* direction, float footprint) const {
    const Look& look = looks_[primitive];
    const SurfaceHit hit = locate(bvh_.primitives()[primitive], p, direction);
    const float s = look.s[0] + hit.u * look.s[1] + hit.v * look.s[2];
    const float t = look.t[0] + hit.u * look.t[1] + hit.v * look.t[2];
    // A slanted footprint is long one way only: its samples share the stretch with the filter.
    const float width = footprint / std::sqrt(std::max(hit.cos, 0.05F)) * look.texels_per_metre;
    const float albedo = look.albedo_offset + look.albedo_slope * textures_[look.texture].sample(s, t, width);
    return albedo * (look.emission + light_at(look, hit.u, hit.v));
}

float Scene::light_at(const Look& look, float u, float v) const {
    if (look.light_width == 0) {
        return look.light[0] + u * look.light[1] + v * look.light[2];
    }
    const float x = std::clamp(u, 0.0F, 1.0F) * static_cast<float>(look.light_width - 1);
    const float y = std::clamp(v, 0.0F, 1.0F) * static_cast<float>(look.light_height - 1);
    const int ix = std::min(static_cast<int>(x), look.light_width - 2);
    const int iy = std::min(static_cast<int>(y), look.light_height - 2);
    const float fx = x - static_cast<float>(ix);
    const float fy = y - static_cast<float>(iy);
    const float* at = light_.data() + look.light_offset + iy * look.light_width + ix;
    const float low = at[0] + fx * (at[1] - at[0]);
    const float high = at[look.light_width] + fx * (at[look.light_width + 1] - at[look.light_width]);
    return low + fy * (high - low);
}

float Scene::blotch(const Look& look, double u, double v) const {
    // In texture coordinates, turned and stretched so that the sum with the texture repeats nowhere in sight.
    constexpr float kScale = 0.2887F;
    constexpr float kTurn = 0.13F;
    const auto uf = static_cast<float>(u);
    const auto vf = static_cast<float>(v);
    const float s = look.s[0] + uf * look.s[1] + vf * look.s[2];
    const float t = look.t[0] + uf * look.t[1] + vf * look.t[2];
    const float slow = textures_[0].sample(kScale * s + kTurn * t, kScale * t - kTurn * s, 0.0F);
    return 1.0F + look.blotches * (slow * (2.0F / 255.0F) - 1.0F);
}

void Scene::bake_light(std::span<const AreaLight> lights, double ambient, std::span<const Vector3d> vertices,
                       std::span<const Vector3d> normals, const SceneDetail& detail) {
    const LightGatherer gatherer(bvh_, lights, ambient, detail.light_samples);
    std::vector<float> vertex_light(vertices.size());
    parallel_for(static_cast<int>(vertices.size()), detail.threads,
                 [&](int i) { vertex_light[i] = gatherer.at(vertices[i], normals[i]); });

    std::uint32_t total = 0;
    for (std::size_t i = 0; i < looks_.size(); ++i) {
        Look& look = looks_[i];
        const Surface& surface = surfaces_[bvh_.primitives()[i].surface];
        if (surface.shape.shape == Shape::kTriangle) {
            const float a = blotch(look, 0, 0) * vertex_light[surface.corners[0]];
            look.light[0] = a;
            look.light[1] = blotch(look, 1, 0) * vertex_light[surface.corners[1]] - a;
            look.light[2] = blotch(look, 0, 1) * vertex_light[surface.corners[2]] - a;
            continue;
        }
        const Eigen::Vector2d extent = surface_extent(surface.shape);
        const auto nodes = [&](double length, int least) {
            return static_cast<std::uint16_t>(
                std::clamp(static_cast<int>(std::ceil(length / detail.light_spacing_m)) + 1, least, 250));
        };
        look.light_width = nodes(extent.x(), is_planar(surface.shape.shape) ? 3 : 9);
        look.light_height = nodes(extent.y(), 3);
        look.light_offset = total;
        total += static_cast<std::uint32_t>(look.light_width) * look.light_height;
    }
    light_.assign(total, 0.0F);
    parallel_for(static_cast<int>(looks_.size()), detail.threads, [&](int i) {
        if (looks_[i].light_width > 0) {
            bake_light_map(gatherer, looks_[i], shapes_[bvh_.primitives()[i].surface]);
        }
    });
}

void Scene::bake_light_map(const LightGatherer& gatherer, const Look& look, const SurfaceShape& shape) {
    for (int y = 0; y < look.light_height; ++y) {
        for (int x = 0; x < look.light_width; ++x) {
            const double u = static_cast<double>(x) / (look.light_width - 1);
            const double v = static_cast<double>(y) / (look.light_height - 1);
            // Border nodes gather a little inside, so that they are not dark for lying in the neighbour's plane.
            const double inset = is_planar(shape.shape) ? 0.03 / std::max(1.0, shape.edge_u.norm()) : 0.0;
            const double ui = std::clamp(u, inset, 1.0 - inset);
            const double vi = std::clamp(v, 0.01, 0.99);
            light_[look.light_offset + y * look.light_width + x] =
                blotch(look, u, v) * gatherer.at(surface_point(shape, ui, vi), surface_normal(shape, ui, vi));
        }
    }
}

}  // namespace facet::sim
