// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/face_filter.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace facet {
namespace {

// A face with a longer side than this needs lonely_neighbours neighbours in its plane (m).
constexpr double kLonelySide_m = 0.7;
// An image gradient is strong above this difference of grey levels over two pixels.
constexpr double kStrongGradient = 60.0;
// The depths of two corners of a face differ if they do by more than this many standard deviations.
constexpr double kStepSigmas = 3.0;
constexpr double kMarginPx = 2.0;  // ends of a side: corners are where gradients are strong

/// Whether the image changes strongly somewhere between two pixels, in steps of two pixels.
bool crosses_gradient(const ImageView& image, const Eigen::Vector2f& a, const Eigen::Vector2f& b, double strong) {
    const Eigen::Vector2f d = b - a;
    const float length = d.norm();
    if (image.empty() || !(length > 2.0F * static_cast<float>(kMarginPx) + 2.0F)) {
        return false;
    }
    // Counted from the outer corner of the first pixel, so that the pixel is the whole part.
    const Eigen::Vector2f begin = a.array() + 0.5F;
    const Eigen::Vector2f end(static_cast<float>(image.width) - 0.5F, static_cast<float>(image.height) - 0.5F);
    const auto grey = [&](float s) {
        const Eigen::Vector2f p = (begin + (s / length) * d).cwiseMax(0.0F).cwiseMin(end);
        return static_cast<int>(image.at(static_cast<int>(p.x()), static_cast<int>(p.y())));
    };
    int last = grey(static_cast<float>(kMarginPx));
    for (float s = static_cast<float>(kMarginPx) + 2.0F; s <= length - static_cast<float>(kMarginPx); s += 2.0F) {
        const int now = grey(s);
        if (std::abs(now - last) > strong) {
            return true;
        }
        last = now;
    }
    return false;
}

struct Corners {
    std::array<const MeshPoint*, 3> p;
    const Eigen::Vector3d& at(std::size_t k) const { return p[k % 3]->p_C; }
    Eigen::Vector3d normal() const { return (at(1) - at(0)).cross(at(2) - at(0)).normalized(); }
};

Corners corners_of(const Triangle& t, std::span<const MeshPoint> points) {
    return {{&points[t.point[0]], &points[t.point[1]], &points[t.point[2]]}};
}

double squared(double x) { return x * x; }

/// Extents along and across the ray are compared as products with the centroid c, all multiplied by |c|: this needs no
/// square root.
/// @param least_cosine  between normal and ray
FaceVerdict judge_shape(const FaceRules& rules, double least_cosine, const Corners& c) {
    const Eigen::Vector3d centroid = (c.at(0) + c.at(1) + c.at(2)) / 3.0;
    const double centroid2 = centroid.squaredNorm();
    const std::array<double, 3> along{centroid.dot(c.at(0)), centroid.dot(c.at(1)), centroid.dot(c.at(2))};
    double shortest2 = 1e300;
    double longest2 = 0.0;
    double across2 = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
        const double length2 = (c.at(k + 1) - c.at(k)).squaredNorm();
        shortest2 = std::min(shortest2, length2);
        longest2 = std::max(longest2, length2);
        across2 = std::max(across2, length2 * centroid2 - squared(along[(k + 1) % 3] - along[k]));
    }
    const double depth = std::max({along[0], along[1], along[2]}) - std::min({along[0], along[1], along[2]});
    if (longest2 > squared(rules.max_flat_side_m)) {
        return FaceVerdict::kSideLength;
    }
    if (shortest2 < squared(rules.min_side_ratio) * longest2) {
        return FaceVerdict::kSideRatio;
    }
    if (across2 < squared(rules.min_elongation * depth)) {
        return FaceVerdict::kElongation;
    }
    const Eigen::Vector3d cross = (c.at(1) - c.at(0)).cross(c.at(2) - c.at(0));
    return squared(cross.dot(centroid)) < squared(least_cosine) * cross.squaredNorm() * centroid2
               ? FaceVerdict::kGrazing
               : FaceVerdict::kAccepted;
}

FaceVerdict judge_steps(const FaceRules& rules, const Corners& c, const ImageView& image) {
    FaceVerdict verdict = FaceVerdict::kAccepted;
    for (std::size_t k = 0; k < 3; ++k) {
        const MeshPoint& a = *c.p[k];
        const MeshPoint& b = *c.p[(k + 1) % 3];
        const double gap = std::abs(a.p_C.z() - b.p_C.z());
        if (squared(gap) <= squared(kStepSigmas) * (squared(a.depth_sigma_m) + squared(b.depth_sigma_m))) {
            continue;
        }
        const double lateral =
            std::min(a.p_C.z(), b.p_C.z()) * (a.p_C.head<2>() / a.p_C.z() - b.p_C.head<2>() / b.p_C.z()).norm();
        if (gap > rules.max_step_slope * lateral) {
            return FaceVerdict::kDepthStep;
        }
        if (gap > rules.gradient_step_slope * lateral && crosses_gradient(image, a.pixel, b.pixel, kStrongGradient)) {
            verdict = FaceVerdict::kGradient;
        }
    }
    return verdict;
}

/// Neighbours whose far corner lies in the triangle's plane.
int coplanar_neighbours(const FaceRules& rules, std::span<const Triangle> triangles, std::span<const MeshPoint> points,
                        std::span<const FaceVerdict> shapes, std::size_t index) {
    const Triangle& t = triangles[index];
    const Corners c = corners_of(t, points);
    const Eigen::Vector3d normal = c.normal();
    int coplanar = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        if (t.neighbour[k] < 0 || shapes[static_cast<std::size_t>(t.neighbour[k])] == FaceVerdict::kLandmark) {
            continue;
        }
        const Triangle& other = triangles[static_cast<std::size_t>(t.neighbour[k])];
        for (const std::uint16_t p : other.point) {
            if (p != t.point[0] && p != t.point[1] && p != t.point[2]) {
                coplanar += std::abs(normal.dot(points[p].p_C - c.at(0))) < rules.coplanar_m ? 1 : 0;
            }
        }
    }
    return coplanar;
}

}  // namespace

void filter_faces(const FaceRules& rules, std::span<const Triangle> triangles, std::span<const MeshPoint> points,
                  const ImageView& image, std::span<FaceVerdict> verdicts) {
    const double least_cosine = std::cos(rules.max_grazing_deg * std::numbers::pi / 180.0);
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        const Corners c = corners_of(triangles[i], points);
        verdicts[i] = FaceVerdict::kLandmark;
        if (c.p[0]->is_usable && c.p[1]->is_usable && c.p[2]->is_usable) {
            verdicts[i] = judge_shape(rules, least_cosine, c);
        }
    }
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        if (verdicts[i] != FaceVerdict::kAccepted) {
            continue;
        }
        const Corners c = corners_of(triangles[i], points);
        const double longest2 = std::max(
            {(c.at(1) - c.at(0)).squaredNorm(), (c.at(2) - c.at(1)).squaredNorm(), (c.at(0) - c.at(2)).squaredNorm()});
        const bool is_large = longest2 > kLonelySide_m * kLonelySide_m;
        const FaceVerdict doubt =
            longest2 > rules.max_side_m * rules.max_side_m ? FaceVerdict::kSideLength : judge_steps(rules, c, image);
        if (doubt == FaceVerdict::kAccepted && !is_large) {
            continue;
        }
        const int support = coplanar_neighbours(rules, triangles, points, verdicts, i);
        if (doubt != FaceVerdict::kAccepted && support < 2) {
            verdicts[i] = doubt;
        } else if (is_large && support < rules.lonely_neighbours) {
            verdicts[i] = FaceVerdict::kLonely;
        }
    }
    for (std::size_t i = 0; i < triangles.size() && rules.lonely_neighbours > 0; ++i) {
        const auto is_face = [&](std::int16_t n) {
            return n >= 0 && (verdicts[static_cast<std::size_t>(n)] == FaceVerdict::kAccepted ||
                              verdicts[static_cast<std::size_t>(n)] == FaceVerdict::kLonely);
        };
        const auto& around = triangles[i].neighbour;
        if (verdicts[i] == FaceVerdict::kAccepted && std::none_of(around.begin(), around.end(), is_face)) {
            verdicts[i] = FaceVerdict::kLonely;
        }
    }
}

}  // namespace facet
