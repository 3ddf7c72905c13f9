// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/range_query.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace facet {
namespace {

constexpr double kFar = std::numeric_limits<double>::max();
// Bounding spheres are floats: a slack so that no face is missed by rounding.
constexpr float kSlack = 1e-4F;

/// Nearest point to the origin of the triangle abc.
Eigen::Vector3d nearest_to_origin(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
    const Eigen::Vector3d n = (b - a).cross(c - a);
    const double nn = n.squaredNorm();
    if (nn > 0.0 && n.dot(a.cross(b)) >= 0.0 && n.dot(b.cross(c)) >= 0.0 && n.dot(c.cross(a)) >= 0.0) {
        return (n.dot(a) / nn) * n;
    }
    const auto on_side = [](const Eigen::Vector3d& from, const Eigen::Vector3d& to) -> Eigen::Vector3d {
        const Eigen::Vector3d side = to - from;
        const double length2 = side.squaredNorm();
        return length2 > 0.0 ? (from + std::clamp(-from.dot(side) / length2, 0.0, 1.0) * side).eval() : from;
    };
    Eigen::Vector3d best = on_side(a, b);
    for (const Eigen::Vector3d& p : {on_side(b, c), on_side(c, a)}) {
        best = p.squaredNorm() < best.squaredNorm() ? p : best;
    }
    return best;
}

/// Parameter where the ray t d from the origin meets the triangle, or infinity. [Moeller97]
double meet(const Eigen::Vector3d& d, const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
    const Eigen::Vector3d e1 = b - a;
    const Eigen::Vector3d e2 = c - a;
    const Eigen::Vector3d h = d.cross(e2);
    const double det = e1.dot(h);
    if (det == 0.0) {
        return kFar;
    }
    const double u = -a.dot(h) / det;
    const Eigen::Vector3d q = e1.cross(a);  // (-a) x e1
    const double v = d.dot(q) / det;
    const double t = e2.dot(q) / det;
    return u < 0.0 || v < 0.0 || u + v > 1.0 || t < 0.0 ? kFar : t;
}

/// Keeps the nearest of the points within a cone around `axis` (unit) from the origin.
struct ConeSearch {
    Eigen::Vector3d axis;
    double cosine;
    double sine;
    double best = kFar;
    Eigen::Vector3d point = Eigen::Vector3d::Zero();

    bool contains(const Eigen::Vector3d& p) const { return axis.dot(p) >= (cosine - 1e-12) * p.norm(); }

    void offer(const Eigen::Vector3d& p) {
        const double d = p.norm();
        if (d < best && contains(p)) {
            best = d;
            point = p;
        }
    }

    /// The part of a side within the cone: its nearest point, or where it crosses the cone's surface.
    void offer_side(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
        const Eigen::Vector3d side = to - from;
        const double length2 = side.squaredNorm();
        if (!(length2 > 0.0)) {
            offer(from);
            return;
        }
        offer(from + std::clamp(-from.dot(side) / length2, 0.0, 1.0) * side);
        // (axis . p)^2 = cos^2 |p|^2 with p = from + t side
        const double c2 = cosine * cosine;
        const double s = axis.dot(side);
        const double f = axis.dot(from);
        const double qa = s * s - c2 * length2;
        const double qb = s * f - c2 * from.dot(side);
        const double qc = f * f - c2 * from.squaredNorm();
        const double disc = qb * qb - qa * qc;
        if (qa == 0.0 || disc < 0.0) {
            return;
        }
        for (const double root : {(-qb + std::sqrt(disc)) / qa, (-qb - std::sqrt(disc)) / qa}) {
            if (root >= 0.0 && root <= 1.0) {
                offer(from + root * side);
            }
        }
    }

    /// The distance is convex over the intersection of triangle and cone: its least value is at the foot of the
    /// perpendicular, on a side, or where the ray of the cone nearest to the perpendicular meets the triangle.
    void offer_face(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
        offer(nearest_to_origin(a, b, c));
        offer_side(a, b);
        offer_side(b, c);
        offer_side(c, a);
        Eigen::Vector3d n = (b - a).cross(c - a);
        n *= n.dot(a) < 0.0 ? -1.0 : 1.0;
        const Eigen::Vector3d tilt = n - axis.dot(n) * axis;
        if (tilt.squaredNorm() > 0.0) {
            const Eigen::Vector3d ray = cosine * axis + sine * tilt.normalized();
            const double t = meet(ray, a, b, c);
            if (t < kFar) {
                offer(t * ray);
            }
        }
    }
};

}  // namespace

void RangeQuery::update(const HorizonMesh& mesh, int min_observations) {
    count_ = 0;
    for (int i = 0; i < mesh.face_end(); ++i) {
        if (!mesh.is_face(i)) {
            continue;
        }
        const MeshFace& face = mesh.face(static_cast<FaceIndex>(i));
        if (face.observations < min_observations && !face.is_fill) {
            continue;
        }
        if (count_ == 0) {
            middle_ = mesh.corner(face, 0);
        }
        const auto n = static_cast<std::size_t>(count_++);
        face_[n] = static_cast<FaceIndex>(i);
        for (std::size_t k = 0; k < 3; ++k) {
            corners_[n][k] = (mesh.corner(face, static_cast<int>(k)) - middle_).cast<float>();
        }
        const Eigen::Vector3f centre = (corners_[n][0] + corners_[n][1] + corners_[n][2]) / 3.0F;
        x_[n] = centre.x();
        y_[n] = centre.y();
        z_[n] = centre.z();
        float radius2 = 0.0F;
        float radius2_xy = 0.0F;
        low_z_[n] = high_z_[n] = centre.z();
        for (const Eigen::Vector3f& c : corners_[n]) {
            radius2 = std::max(radius2, (c - centre).squaredNorm());
            radius2_xy = std::max(radius2_xy, (c - centre).head<2>().squaredNorm());
            low_z_[n] = std::min(low_z_[n], c.z());
            high_z_[n] = std::max(high_z_[n], c.z());
        }
        radius_[n] = std::sqrt(radius2) + kSlack;
        radius_xy_[n] = std::sqrt(radius2_xy) + kSlack;
    }
}

RangeHit RangeQuery::found(double distance, const Eigen::Vector3d& p, std::size_t i) const {
    return {distance, middle_ + p, face_[i]};
}

RangeHit RangeQuery::nearest(const Eigen::Vector3d& p_W, double max_range_m) const {
    const Eigen::Vector3d p = p_W - middle_;
    const Eigen::Vector3f q = p.cast<float>();
    const auto n = static_cast<std::size_t>(count_);
    // No face is farther than its sphere's centre plus radius: spheres beyond the least of these are out.
    float within = static_cast<float>(max_range_m);
    for (std::size_t i = 0; i < n; ++i) {
        const float dx = x_[i] - q.x();
        const float dy = y_[i] - q.y();
        const float dz = z_[i] - q.z();
        within = std::min(within, std::sqrt(dx * dx + dy * dy + dz * dz) + radius_[i]);
    }
    RangeHit hit{.distance_m = max_range_m};
    for (std::size_t i = 0; i < n; ++i) {
        const float reach = within + radius_[i];
        const Eigen::Vector3f d(x_[i] - q.x(), y_[i] - q.y(), z_[i] - q.z());
        if (d.squaredNorm() <= reach * reach) {
            const Eigen::Vector3d at = nearest_to_origin(corner(i, 0) - p, corner(i, 1) - p, corner(i, 2) - p);
            if (at.norm() < hit.distance_m) {
                hit = found(at.norm(), p + at, i);
            }
        }
    }
    return hit;
}

RangeHit RangeQuery::cast(const Eigen::Vector3d& p_W, const Eigen::Vector3d& direction, double max_range_m) const {
    const Eigen::Vector3d p = p_W - middle_;
    const Eigen::Vector3d d = direction.normalized();
    const Eigen::Vector3f q = p.cast<float>();
    const Eigen::Vector3f e = d.cast<float>();
    RangeHit hit{.distance_m = max_range_m};
    for (std::size_t i = 0; i < static_cast<std::size_t>(count_); ++i) {
        const float vx = x_[i] - q.x();
        const float vy = y_[i] - q.y();
        const float vz = z_[i] - q.z();
        const float along = vx * e.x() + vy * e.y() + vz * e.z();
        const float aside2 = vx * vx + vy * vy + vz * vz - along * along;
        const float slack = kSlack * (1.0F + std::abs(along));
        const float reach = radius_[i] + slack;
        if (aside2 > reach * reach || along < -reach || along - reach > static_cast<float>(hit.distance_m)) {
            continue;
        }
        const double t = meet(d, corner(i, 0) - p, corner(i, 1) - p, corner(i, 2) - p);
        if (t < hit.distance_m) {
            hit = found(t, p + t * d, i);
        }
    }
    return hit;
}

RangeHit RangeQuery::nearest_in_direction(const Eigen::Vector3d& p_W, const Eigen::Vector3d& direction,
                                          double half_angle_rad, double max_range_m) const {
    const Eigen::Vector3d p = p_W - middle_;
    const Eigen::Vector3f q = p.cast<float>();
    ConeSearch search{direction.normalized(), std::cos(half_angle_rad), std::sin(half_angle_rad), max_range_m};
    const Eigen::Vector3f axis = search.axis.cast<float>();
    const auto cosine = static_cast<float>(search.cosine);
    const auto sine = static_cast<float>(search.sine);
    RangeHit hit{.distance_m = max_range_m};
    for (std::size_t i = 0; i < static_cast<std::size_t>(count_); ++i) {
        const Eigen::Vector3f v(x_[i] - q.x(), y_[i] - q.y(), z_[i] - q.z());
        const float v2 = v.squaredNorm();
        const float along = axis.dot(v);
        const float aside = std::sqrt(std::max(0.0F, v2 - along * along));
        const float reach = radius_[i] + kSlack * (1.0F + std::abs(along));
        const float range = static_cast<float>(search.best) + reach;
        if (aside * cosine - along * sine > reach || v2 > range * range) {
            continue;
        }
        const double before = search.best;
        search.offer_face(corner(i, 0) - p, corner(i, 1) - p, corner(i, 2) - p);
        if (search.best < before) {
            hit = found(search.best, p + search.point, i);
        }
    }
    return hit;
}

}  // namespace facet
