// SPDX-License-Identifier: BSD-2-Clause
// The surfaces a scene is made of, their parametrisation, distance and ray intersection.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "app/lab/sim/simd.h"

namespace facet::sim {

enum class Shape : std::uint8_t { kRectangle, kTriangle, kDisk, kSphere, kCylinder };

/// One surface as the scene's author describes it, world frame, metres. Parameters (u, v), see surface_point:
///   rectangle  origin + u edge_u + v edge_v, u and v in [0, 1], edges orthogonal
///   triangle   the same with u + v <= 1, edges free
///   disk       the ellipse inscribed in the rectangle
///   sphere     origin = centre; u longitude / 2 pi + 1/2 about world z, v latitude / pi + 1/2
///   cylinder   origin = centre of the base, edge_v = axis times length, edge_u = unit vector of angle 0;
///              u angle / 2 pi + 1/2, v along the axis; no caps
/// The normal is edge_u x edge_v for planar shapes, outward for curved ones. Seen and hit from both sides.
struct SurfaceShape {
    Shape shape = Shape::kRectangle;
    Eigen::Vector3d origin = Eigen::Vector3d::Zero();
    Eigen::Vector3d edge_u = Eigen::Vector3d::Zero();
    Eigen::Vector3d edge_v = Eigen::Vector3d::Zero();
    double radius = 0.0;
};

constexpr bool is_planar(Shape s) { return s == Shape::kRectangle || s == Shape::kTriangle || s == Shape::kDisk; }

/// Point of the surface at (u, v). Reentrant. No heap.
Eigen::Vector3d surface_point(const SurfaceShape& s, double u, double v);
/// Unit normal at (u, v).
Eigen::Vector3d surface_normal(const SurfaceShape& s, double u, double v);
/// Distance from a point to the nearest point of the surface (m).
double surface_distance(const SurfaceShape& s, const Eigen::Vector3d& p);
/// Arc lengths of the u and v ranges (m): the sphere's at its equator and along a meridian.
Eigen::Vector2d surface_extent(const SurfaceShape& s);
double surface_area(const SurfaceShape& s);

/// Axis-aligned box.
struct Box {
    Eigen::Vector3f low = Eigen::Vector3f::Constant(1e30F);
    Eigen::Vector3f high = Eigen::Vector3f::Constant(-1e30F);

    void include(const Box& o) {
        low = low.cwiseMin(o.low);
        high = high.cwiseMax(o.high);
    }
    float half_area() const {
        const Eigen::Vector3f d = (high - low).cwiseMax(0.0F);
        return d.x() * d.y() + d.y() * d.z() + d.z() * d.x();
    }
};

/// Box around a surface, padded by 0.1 mm so that flat boxes survive rounding.
Box surface_box(const SurfaceShape& s);

/// A surface as the ray caster stores it, one cache line. Planar: g = normal 0..2, offset 3 (n . p = offset), and the
/// affine maps u = g[4..6] . p + g[7], v = g[8..10] . p + g[11]. Sphere: centre 0..2, radius 3. Cylinder: base 0..2,
/// radius 3, axis 4..6, length 7, angle-0 vector 8..10.
struct alignas(64) Primitive {
    Shape shape = Shape::kRectangle;
    std::uint32_t surface = 0;  ///< index of the surface it was made from
    float g[14] = {};
};

Primitive make_primitive(const SurfaceShape& s, std::uint32_t surface);

/// Four rays, unit directions, and the nearest hit found so far: t starts at the farthest distance of interest (m), at
/// most kFar; primitive -1 means none.
struct RayPacket {
    static constexpr float kFar = 1e4F;
    V4 origin;
    V4 direction;
    F4 t;
    I4 primitive;
};

/// Lowers the packet's t and sets its primitive to `index` where the ray hits `primitive` nearer than before and
/// farther than 0.1 mm. Reentrant. No heap.
void intersect(const Primitive& primitive, int index, RayPacket& packet);

/// Parameters (u, v) of a point on a primitive and |cos| of the angle between ray and normal.
struct SurfaceHit {
    float u = 0.0F;
    float v = 0.0F;
    float cos = 1.0F;
};
SurfaceHit locate(const Primitive& primitive, const float* p, const float* direction);

}  // namespace facet::sim
