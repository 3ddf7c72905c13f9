// SPDX-License-Identifier: BSD-2-Clause
// A textured, lit scene that rays can be cast into, and the builder that puts one together.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app/lab/sim/bvh.h"
#include "app/lab/sim/patterns.h"

namespace facet::sim {

/// How a surface reflects: albedo runs from `dark` at texel 0 to `bright` at texel 255.
struct Material {
    Pattern pattern = Pattern::kPlain;
    std::uint32_t seed = 0;
    double tile_m = 2.0;  ///< side of the texture's square (m); 0 = stretched once over the surface
    float dark = 0.05F;
    float bright = 0.8F;
    float blotches = 0.35F;  ///< strength of slow stains that hide the repetition; baked into the light
    float emission = 0.0F;   ///< glows as if this irradiance fell on it (lamps, windows)
};
using MaterialId = int;

/// A rectangular lamp, in addition to the surface that shows it.
struct AreaLight {
    Eigen::Vector3d centre;
    Eigen::Vector3d half_u;
    Eigen::Vector3d half_v;
    Eigen::Vector3d normal;
    double power = 1.0;  ///< irradiance at 1 m straight below times m^2
};

/// A triangle mesh with texture coordinates in metres.
struct Mesh {
    std::vector<Eigen::Vector3d> vertices;
    std::vector<Eigen::Vector2d> texture_m;
    std::vector<Eigen::Vector3i> triangles;
};

/// One surface of a scene.
struct Surface {
    SurfaceShape shape;
    std::string name;  ///< object and side, e.g. "table.top"
    MaterialId material = 0;
    Eigen::Vector2d texture_m[3] = {};  ///< triangles: of the three corners
    std::uint32_t corners[3] = {};      ///< triangles: vertices of the light bake, shared between neighbours
};

/// Free volume and start of flights through a scene.
struct FlightVolume {
    static constexpr double kEverywhere = 1e9;

    Eigen::Vector3d low;
    Eigen::Vector3d high;
    Eigen::Vector3d start;
    double start_yaw_rad = 0.0;
    double clearance_m = 0.5;
    double reach_m = kEverywhere;        ///< along each axis, of one leg of a flight
    std::vector<Eigen::Vector3d> gates;  ///< places on both sides of doorways, for legs that lead through them
};

/// Cost of preparation: small values for tests.
struct SceneDetail {
    int texture_size = 1024;        ///< texels of the large textures
    double light_spacing_m = 0.08;  ///< of the light bake
    int light_samples = 16;         ///< shadow rays per lamp and point, and twice as many towards the surroundings
    double contrast = 1.0;          ///< of all materials, about their middle albedo [0, 1]; lamps shine as before
    int threads = 1;
};

/// What a single ray meets.
struct RayHit {
    int surface = -1;  ///< index into Scene::surfaces(), -1: nothing
    double distance = 0.0;
    double u = 0.0;
    double v = 0.0;
};

/// Immutable once built; all queries reentrant, without heap.
class Scene {
public:
    const std::string& name() const { return name_; }
    std::span<const Surface> surfaces() const { return surfaces_; }
    std::span<const SurfaceShape> shapes() const { return shapes_; }
    const FlightVolume& flight_volume() const { return volume_; }
    const Bvh& bvh() const { return bvh_; }

    /// Nearest hit of one ray. @param direction unit length
    RayHit cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;

    /// Distance to the nearest surface, at most `limit` (m).
    double clearance(const Eigen::Vector3d& p, double limit) const { return bvh_.distance(shapes_, p, limit); }

    /// Radiance of four hits; 0 where nothing was hit.
    /// @param packet    after Bvh::intersect
    /// @param spread    width of a sample's cone per metre (-): chooses the texture level
    void shade(const RayPacket& packet, float spread, float* radiance) const;

private:
    friend class SceneBuilder;

    /// What shading needs of a surface, in tree order. Texture coordinates, and the light of triangles, are affine in
    /// (u, v).
    struct Look {
        float s[3], t[3];        ///< s = s[0] + u s[1] + v s[2]
        float light[3];          ///< triangles
        float texels_per_metre;  ///< in units of the texture's square
        float albedo_offset, albedo_slope;
        float blotches;
        float emission;
        std::uint32_t light_offset;
        std::uint16_t light_width, light_height;  ///< 0: affine light
        std::uint16_t texture;
    };
    float radiance(int primitive, const float* p, const float* direction, float footprint) const;
    float light_at(const Look& look, float u, float v) const;
    float blotch(const Look& look, double u, double v) const;
    void bake_light_map(const class LightGatherer& gatherer, const Look& look, const SurfaceShape& shape);
    void bake_light(std::span<const AreaLight> lights, double ambient, std::span<const Eigen::Vector3d> vertices,
                    std::span<const Eigen::Vector3d> normals, const SceneDetail& detail);

    std::string name_;
    FlightVolume volume_;
    std::vector<Surface> surfaces_;
    std::vector<SurfaceShape> shapes_;
    Bvh bvh_;
    std::vector<Look> looks_;
    std::vector<Texture> textures_;
    std::vector<float> light_;
};

/// Puts a scene together. Heap; thread-bound.
class SceneBuilder {
public:
    explicit SceneBuilder(std::string name) { scene_.name_ = std::move(name); }

    MaterialId material(const Material& m);
    void rectangle(std::string name, MaterialId m, const Eigen::Vector3d& origin, const Eigen::Vector3d& edge_u,
                   const Eigen::Vector3d& edge_v);
    /// Box turned by yaw about z; sides are named .top .bottom .front (+x) .back .left (+y) .right.
    void box(const std::string& name, MaterialId sides, MaterialId top, const Eigen::Vector3d& centre,
             const Eigen::Vector3d& size, double yaw_rad = 0.0);
    void box(const std::string& name, MaterialId m, const Eigen::Vector3d& centre, const Eigen::Vector3d& size,
             double yaw_rad = 0.0) {
        box(name, m, m, centre, size, yaw_rad);
    }
    void cylinder(const std::string& name, MaterialId m, const Eigen::Vector3d& base, const Eigen::Vector3d& axis,
                  double radius, bool caps = false);
    void sphere(const std::string& name, MaterialId m, const Eigen::Vector3d& centre, double radius);
    void mesh(const std::string& name, MaterialId m, const Mesh& mesh);
    /// A lamp: bright rectangle facing along half_u x half_v, and its light.
    void lamp(const std::string& name, MaterialId m, const Eigen::Vector3d& centre, const Eigen::Vector3d& half_u,
              const Eigen::Vector3d& half_v, double power);
    void ambient(double irradiance) { ambient_ = irradiance; }
    void flight_volume(const FlightVolume& volume) { scene_.volume_ = volume; }

    /// Bakes textures and light. The builder is empty afterwards.
    Scene build(const SceneDetail& detail);

private:
    void add(std::string name, MaterialId m, const SurfaceShape& shape);
    void bake_textures(const SceneDetail& detail);
    Scene::Look look_of(const Surface& surface, double contrast) const;

    Scene scene_;
    std::vector<Material> materials_;
    std::vector<AreaLight> lights_;
    std::vector<Eigen::Vector3d> vertices_;
    std::vector<Eigen::Vector3d> normals_;
    double ambient_ = 0.3;
};

/// Names of the scenes there are.
std::span<const std::string_view> scene_names();
/// The named scene; the name must be one of scene_names(). The seed decides what a building is like; the other scenes
/// are always the same.
Scene make_scene(std::string_view name, const SceneDetail& detail, std::uint64_t seed = 1);

Scene make_room(const SceneDetail& detail);
Scene make_hall(const SceneDetail& detail);
Scene make_building(const SceneDetail& detail, std::uint64_t seed);

}  // namespace facet::sim
