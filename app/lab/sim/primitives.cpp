// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/sim/primitives.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace facet::sim {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr float kNearest = 1e-4F;
constexpr float kEdgeTolerance = 2e-5F;    // closes cracks between neighbouring rectangles
constexpr float kCornerTolerance = 1e-4F;  // and between triangles, whose coordinates round more for being small

Eigen::Vector3d planar_normal(const SurfaceShape& s) { return s.edge_u.cross(s.edge_v).normalized(); }

Eigen::Vector3d radial_direction(const SurfaceShape& s, double u) {
    const Eigen::Vector3d axis = s.edge_v.normalized();
    const double angle = 2.0 * kPi * (u - 0.5);
    return std::cos(angle) * s.edge_u + std::sin(angle) * axis.cross(s.edge_u);
}

Eigen::Vector3d sphere_direction(double u, double v) {
    const double longitude = 2.0 * kPi * (u - 0.5);
    const double latitude = kPi * (v - 0.5);
    return {std::cos(latitude) * std::cos(longitude), std::cos(latitude) * std::sin(longitude), std::sin(latitude)};
}

double segment_distance(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& edge) {
    const double s = std::clamp((p - a).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
    return (p - a - s * edge).norm();
}

/// (u, v) of the projection of p onto the plane of a planar shape.
Eigen::Vector2d planar_coordinates(const SurfaceShape& s, const Eigen::Vector3d& p) {
    Eigen::Matrix2d gram;
    gram << s.edge_u.squaredNorm(), s.edge_u.dot(s.edge_v), s.edge_u.dot(s.edge_v), s.edge_v.squaredNorm();
    const Eigen::Vector3d d = p - s.origin;
    return gram.inverse() * Eigen::Vector2d(s.edge_u.dot(d), s.edge_v.dot(d));
}

double planar_distance(const SurfaceShape& s, const Eigen::Vector3d& p) {
    const Eigen::Vector2d uv = planar_coordinates(s, p);
    const Eigen::Vector3d d = p - s.origin;
    if (s.shape == Shape::kRectangle) {
        const Eigen::Vector2d c = uv.cwiseMax(0.0).cwiseMin(1.0);
        return (d - c.x() * s.edge_u - c.y() * s.edge_v).norm();
    }
    if (s.shape == Shape::kDisk) {
        // Round disks only: nearest point by clamping the radius.
        Eigen::Vector2d c = 2.0 * uv - Eigen::Vector2d::Ones();
        c /= std::max(1.0, c.norm());
        c = 0.5 * (c + Eigen::Vector2d::Ones());
        return (d - c.x() * s.edge_u - c.y() * s.edge_v).norm();
    }
    if (uv.minCoeff() >= 0.0 && uv.sum() <= 1.0) {
        return std::abs(d.dot(planar_normal(s)));
    }
    return std::min({segment_distance(p, s.origin, s.edge_u), segment_distance(p, s.origin, s.edge_v),
                     segment_distance(p, s.origin + s.edge_u, s.edge_v - s.edge_u)});
}

void intersect_planar(const Primitive& q, int index, RayPacket& r) {
    const float* g = q.g;
    const F4 t = (g[3] - dot(g, r.origin)) / dot(g, r.direction);
    I4 hit = (t > kNearest) & (t < r.t);
    if (!any(hit)) {
        return;
    }
    const V4 p = r.origin + t * r.direction;
    const F4 u = dot(g + 4, p) + g[7];
    const F4 v = dot(g + 8, p) + g[11];
    switch (q.shape) {
        case Shape::kTriangle:
            hit &= (u >= -kCornerTolerance) & (v >= -kCornerTolerance) & (u + v <= 1.0F + kCornerTolerance);
            break;
        case Shape::kDisk: {
            const F4 a = 2.0F * u - 1.0F;
            const F4 b = 2.0F * v - 1.0F;
            hit &= a * a + b * b <= 1.0F;
            break;
        }
        default:
            hit &= (u >= -kEdgeTolerance) & (u <= 1.0F + kEdgeTolerance) & (v >= -kEdgeTolerance) &
                   (v <= 1.0F + kEdgeTolerance);
            break;
    }
    r.t = hit ? t : r.t;
    r.primitive = hit ? I4{index, index, index, index} : r.primitive;
}

// Both curved tests start from the point of the ray nearest to the centre (axis): no cancellation far away.
void intersect_sphere(const Primitive& q, int index, RayPacket& r) {
    const float* g = q.g;
    const V4 oc = r.origin - V4{splat(g[0]), splat(g[1]), splat(g[2])};
    const F4 middle = -dot(oc, r.direction);
    const V4 nearest = oc + middle * r.direction;
    const F4 rest = g[3] * g[3] - dot(nearest, nearest);
    const I4 possible = rest > 0.0F;
    if (!any(possible)) {
        return;
    }
    const F4 half = sqrt4(max4(rest, splat(0.0F)));
    const F4 front = middle - half;
    const F4 t = front > kNearest ? front : middle + half;
    const I4 hit = possible & (t > kNearest) & (t < r.t);
    r.t = hit ? t : r.t;
    r.primitive = hit ? I4{index, index, index, index} : r.primitive;
}

void intersect_cylinder(const Primitive& q, int index, RayPacket& r) {
    const float* g = q.g;
    const V4 oc = r.origin - V4{splat(g[0]), splat(g[1]), splat(g[2])};
    const V4 axis{splat(g[4]), splat(g[5]), splat(g[6])};
    const F4 d_axial = dot(r.direction, axis);
    const F4 o_axial = dot(oc, axis);
    const V4 d_radial = r.direction - d_axial * axis;
    const V4 o_radial = oc - o_axial * axis;
    const F4 a = max4(dot(d_radial, d_radial), splat(1e-12F));
    const F4 middle = -dot(d_radial, o_radial) / a;
    const V4 nearest = o_radial + middle * d_radial;
    const F4 rest = g[3] * g[3] - dot(nearest, nearest);
    const I4 possible = rest > 0.0F;
    if (!any(possible)) {
        return;
    }
    const F4 half = sqrt4(max4(rest, splat(0.0F)) / a);
    const F4 front = middle - half;
    const F4 back = middle + half;
    const F4 z_front = o_axial + front * d_axial;
    const F4 z_back = o_axial + back * d_axial;
    const I4 front_ok = (front > kNearest) & (z_front >= 0.0F) & (z_front <= g[7]);
    const I4 back_ok = (back > kNearest) & (z_back >= 0.0F) & (z_back <= g[7]);
    const F4 t = front_ok ? front : back;
    const I4 hit = possible & (front_ok | back_ok) & (t < r.t);
    r.t = hit ? t : r.t;
    r.primitive = hit ? I4{index, index, index, index} : r.primitive;
}

/// atan2(y, x) / 2 pi + 1/2 within 2e-6: odd minimax polynomial on [0, 1]; for texture and light coordinates.
float turn(float y, float x) {
    const float ax = std::abs(x);
    const float ay = std::abs(y);
    const float z = std::min(ax, ay) / std::max(std::max(ax, ay), 1e-30F);
    const float z2 = z * z;
    float a =
        z * (0.99997726F +
             z2 * (-0.33262347F + z2 * (0.19354346F + z2 * (-0.11643287F + z2 * (0.05265332F - z2 * 0.01172120F)))));
    a = ay > ax ? 1.57079633F - a : a;
    a = x < 0.0F ? 3.14159265F - a : a;
    return 0.5F + std::copysign(a, y) * 0.15915494F;
}

}  // namespace

Eigen::Vector3d surface_point(const SurfaceShape& s, double u, double v) {
    switch (s.shape) {
        case Shape::kSphere: return s.origin + s.radius * sphere_direction(u, v);
        case Shape::kCylinder: return s.origin + s.radius * radial_direction(s, u) + v * s.edge_v;
        default: return s.origin + u * s.edge_u + v * s.edge_v;
    }
}

Eigen::Vector3d surface_normal(const SurfaceShape& s, double u, double v) {
    switch (s.shape) {
        case Shape::kSphere: return sphere_direction(u, v);
        case Shape::kCylinder: return radial_direction(s, u);
        default: return planar_normal(s);
    }
}

double surface_distance(const SurfaceShape& s, const Eigen::Vector3d& p) {
    const Eigen::Vector3d d = p - s.origin;
    if (s.shape == Shape::kSphere) {
        return std::abs(d.norm() - s.radius);
    }
    if (s.shape == Shape::kCylinder) {
        const double length = s.edge_v.norm();
        const Eigen::Vector3d axis = s.edge_v / length;
        const double z = d.dot(axis);
        const double radial = (d - z * axis).norm() - s.radius;
        return std::hypot(radial, z - std::clamp(z, 0.0, length));
    }
    return planar_distance(s, p);
}

Eigen::Vector2d surface_extent(const SurfaceShape& s) {
    switch (s.shape) {
        case Shape::kSphere: return {2.0 * kPi * s.radius, kPi * s.radius};
        case Shape::kCylinder: return {2.0 * kPi * s.radius, s.edge_v.norm()};
        default: return {s.edge_u.norm(), s.edge_v.norm()};
    }
}

double surface_area(const SurfaceShape& s) {
    switch (s.shape) {
        case Shape::kSphere: return 4.0 * kPi * s.radius * s.radius;
        case Shape::kCylinder: return 2.0 * kPi * s.radius * s.edge_v.norm();
        case Shape::kTriangle: return 0.5 * s.edge_u.cross(s.edge_v).norm();
        case Shape::kDisk: return 0.25 * kPi * s.edge_u.cross(s.edge_v).norm();
        case Shape::kRectangle: break;
    }
    return s.edge_u.cross(s.edge_v).norm();
}

Box surface_box(const SurfaceShape& s) {
    Eigen::Vector3d low;
    Eigen::Vector3d high;
    if (s.shape == Shape::kSphere) {
        low = s.origin.array() - s.radius;
        high = s.origin.array() + s.radius;
    } else if (s.shape == Shape::kCylinder) {
        const Eigen::Vector3d axis = s.edge_v.normalized();
        const Eigen::Vector3d reach = s.radius * (1.0 - axis.array().square()).max(0.0).sqrt();
        low = s.origin.cwiseMin(s.origin + s.edge_v) - reach;
        high = s.origin.cwiseMax(s.origin + s.edge_v) + reach;
    } else {
        const Eigen::Vector3d a = s.origin + s.edge_u;
        const Eigen::Vector3d b = s.origin + s.edge_v;
        low = s.origin.cwiseMin(a).cwiseMin(b);
        high = s.origin.cwiseMax(a).cwiseMax(b);
        if (s.shape != Shape::kTriangle) {
            low = low.cwiseMin(a + s.edge_v);
            high = high.cwiseMax(a + s.edge_v);
        }
    }
    constexpr float kPadding = 1e-4F;
    return {low.cast<float>().array() - kPadding, high.cast<float>().array() + kPadding};
}

Primitive make_primitive(const SurfaceShape& s, std::uint32_t surface) {
    Primitive q;
    q.shape = s.shape;
    q.surface = surface;
    const auto store = [&q](int at, const Eigen::Vector3d& v) {
        for (int i = 0; i < 3; ++i) {
            q.g[at + i] = static_cast<float>(v[i]);
        }
    };
    if (!is_planar(s.shape)) {
        store(0, s.origin);
        q.g[3] = static_cast<float>(s.radius);
        if (s.shape == Shape::kCylinder) {
            store(4, s.edge_v.normalized());
            q.g[7] = static_cast<float>(s.edge_v.norm());
            store(8, s.edge_u.normalized());
        }
        return q;
    }
    const Eigen::Vector3d n = planar_normal(s);
    Eigen::Matrix3d basis;
    basis << s.edge_u, s.edge_v, n;
    const Eigen::Matrix3d dual = basis.inverse();
    store(0, n);
    q.g[3] = static_cast<float>(n.dot(s.origin));
    store(4, dual.row(0).transpose());
    q.g[7] = static_cast<float>(-dual.row(0).dot(s.origin));
    store(8, dual.row(1).transpose());
    q.g[11] = static_cast<float>(-dual.row(1).dot(s.origin));
    return q;
}

void intersect(const Primitive& primitive, int index, RayPacket& packet) {
    switch (primitive.shape) {
        case Shape::kSphere: intersect_sphere(primitive, index, packet); break;
        case Shape::kCylinder: intersect_cylinder(primitive, index, packet); break;
        default: intersect_planar(primitive, index, packet); break;
    }
}

SurfaceHit locate(const Primitive& primitive, const float* p, const float* direction) {
    const float* g = primitive.g;
    const auto dot3 = [](const float* a, const float* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
    if (is_planar(primitive.shape)) {
        return {dot3(g + 4, p) + g[7], dot3(g + 8, p) + g[11], std::abs(dot3(g, direction))};
    }
    const float d[3] = {p[0] - g[0], p[1] - g[1], p[2] - g[2]};
    const float inverse_radius = 1.0F / g[3];
    if (primitive.shape == Shape::kSphere) {
        const float z = std::clamp(d[2] * inverse_radius, -1.0F, 1.0F);
        const float latitude = turn(z, std::sqrt(1.0F - z * z)) - 0.5F;
        return {turn(d[1], d[0]), 2.0F * latitude + 0.5F, std::abs(dot3(d, direction)) * inverse_radius};
    }
    const float* axis = g + 4;
    const float* x = g + 8;
    const float y[3] = {axis[1] * x[2] - axis[2] * x[1], axis[2] * x[0] - axis[0] * x[2],
                        axis[0] * x[1] - axis[1] * x[0]};
    const float axial = dot3(axis, d);
    const float radial[3] = {d[0] - axial * axis[0], d[1] - axial * axis[1], d[2] - axial * axis[2]};
    return {turn(dot3(y, d), dot3(x, d)), axial / g[7], std::abs(dot3(radial, direction)) * inverse_radius};
}

}  // namespace facet::sim
