// SPDX-License-Identifier: BSD-2-Clause
// Stereo pairs of made-up surfaces whose depth is known, as two cameras beside each other see them.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

#include "estimator/geometry/stereo_rig.h"
#include "platform/base/image_view.h"
#include "tests/support/ideal_camera.h"

namespace facet::test {

inline constexpr int kSceneWidth = 320;
inline constexpr int kSceneHeight = 240;

/// Two ideal cameras of f = 240 px, 0.1 m apart; the body is the left one.
inline StereoRig scene_rig() {
    const CameraModel camera = ideal_camera(kSceneWidth, kSceneHeight, 240.0);
    return {camera, camera, Se3{}, Se3{Eigen::Quaterniond::Identity(), {0.1, 0.0, 0.0}}};
}

/// A surface in C0: depth and grey value where a ray meets it.
struct Surface {
    /// Distance along the ray o + t d at which it meets the surface.
    std::function<double(const Eigen::Vector3d& o, const Eigen::Vector3d& d)> meet;
    std::function<double(const Eigen::Vector3d& p)> grey;
};

/// Smooth random grey values, `cell` metres from one random value to the next.
inline double noise_grey(const Eigen::Vector3d& p, double cell) {
    const auto value = [](std::int64_t i, std::int64_t j) {
        auto h = static_cast<std::uint64_t>(i * 73856093 ^ j * 19349663) * 0x9E3779B97F4A7C15ULL;
        h ^= h >> 29U;
        h *= 0xBF58476D1CE4E5B9ULL;
        return static_cast<double>((h >> 40U) & 0xffU);
    };
    const double x = p.x() / cell;
    const double y = p.y() / cell;
    const auto i = static_cast<std::int64_t>(std::floor(x));
    const auto j = static_cast<std::int64_t>(std::floor(y));
    const double fx = x - std::floor(x);
    const double fy = y - std::floor(y);
    return (1.0 - fy) * ((1.0 - fx) * value(i, j) + fx * value(i + 1, j)) +
           fy * ((1.0 - fx) * value(i, j + 1) + fx * value(i + 1, j + 1));
}

/// n . p = d.
inline Surface plane_surface(const Eigen::Vector3d& n, double d, double cell = 0.06) {
    return {[=](const Eigen::Vector3d& o, const Eigen::Vector3d& ray) { return (d - n.dot(o)) / n.dot(ray); },
            [=](const Eigen::Vector3d& p) { return noise_grey(p, cell); }};
}

/// A board at Z = near for X > 0, before a wall at Z = far.
inline Surface step_surface(double near, double far) {
    return {[=](const Eigen::Vector3d& o, const Eigen::Vector3d& ray) {
                const double t = (near - o.z()) / ray.z();
                return o.x() + t * ray.x() > 0.0 ? t : (far - o.z()) / ray.z();
            },
            [](const Eigen::Vector3d& p) { return noise_grey(p + Eigen::Vector3d(0.0, 7.0 * p.z(), 0.0), 0.06); }};
}

/// An image with its pixels.
struct SceneImage {
    std::vector<std::uint8_t> pixels;
    ImageView view() const { return {pixels.data(), kSceneWidth, kSceneHeight, kSceneWidth}; }
};

/// The mean of 2 x 2 rays a pixel. @param centre  of a camera that looks as C0 does
inline SceneImage draw(const Surface& surface, const Eigen::Vector3d& centre) {
    const CameraModel& camera = scene_rig().left;
    SceneImage image;
    for (int v = 0; v < kSceneHeight; ++v) {
        for (int u = 0; u < kSceneWidth; ++u) {
            double sum = 0.0;
            for (const double du : {-0.25, 0.25}) {
                for (const double dv : {-0.25, 0.25}) {
                    Eigen::Vector2d xy;
                    static_cast<void>(camera.unproject({u + du, v + dv}, xy));
                    const Eigen::Vector3d ray = xy.homogeneous();
                    sum += surface.grey(centre + surface.meet(centre, ray) * ray);
                }
            }
            image.pixels.push_back(static_cast<std::uint8_t>(std::lround(sum / 4.0)));
        }
    }
    return image;
}

struct ScenePair {
    SceneImage left;
    SceneImage right;
    explicit ScenePair(const Surface& surface)
        : left(draw(surface, Eigen::Vector3d::Zero())), right(draw(surface, {0.1, 0.0, 0.0})) {}
};

}  // namespace facet::test
