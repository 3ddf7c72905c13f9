// SPDX-License-Identifier: BSD-2-Clause
// Images with exactly known motion: a smooth random texture that can be evaluated anywhere, and a plane to carry it.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "estimator/geometry/stereo_rig.h"
#include "platform/base/image_view.h"

namespace facet::synthetic {

struct Image {
    int width = 0;
    int height = 0;
    std::vector<std::uint8_t> pixels;

    Image(int w, int h, std::uint8_t value = 0)
        : width(w), height(h), pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), value) {}
    ImageView view() const { return {pixels.data(), width, height, width}; }
    void set(int u, int v, double grey) {
        const double rounded = std::clamp(std::round(grey), 0.0, 255.0);
        pixels[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u)] =
            static_cast<std::uint8_t>(rounded);
    }
};

/// Sum of plane waves of random direction and phase; wavelengths between the two given ones; 128 +- 26 grey levels
/// (standard deviation): at this size it hardly ever saturates.
class Texture {
public:
    Texture(double shortest, double longest, unsigned seed, int waves = 32) {
        std::mt19937 random(seed);
        const auto uniform = [&random] { return static_cast<double>(random()) / 4294967296.0; };
        for (int i = 0; i < waves; ++i) {
            const double length = shortest * std::pow(longest / shortest, uniform());
            const double angle = 2.0 * M_PI * uniform();
            const double k = 2.0 * M_PI / length;
            waves_.push_back({k * std::cos(angle), k * std::sin(angle), 2.0 * M_PI * uniform()});
        }
        amplitude_ = 26.0 * std::sqrt(2.0 / waves);
    }
    double at(double x, double y) const {
        double sum = 128.0;
        for (const Wave& w : waves_) {
            sum += amplitude_ * std::sin(w.kx * x + w.ky * y + w.phase);
        }
        return sum;
    }

private:
    struct Wave {
        double kx, ky, phase;
    };
    std::vector<Wave> waves_;
    double amplitude_ = 0.0;
};

/// Image of the texture under x_texture = A^-1 (u - c - shift) + c, c the image centre: a template point at u is seen
/// at A (u - c) + c + shift.
inline Image warp(const Texture& texture, int width, int height, const Eigen::Vector2d& shift,
                  const Eigen::Matrix2d& A = Eigen::Matrix2d::Identity(), double gain = 1.0, double offset = 0.0) {
    Image image(width, height);
    const Eigen::Vector2d c(0.5 * (width - 1), 0.5 * (height - 1));
    const Eigen::Matrix2d inverse = A.inverse();
    for (int v = 0; v < height; ++v) {
        for (int u = 0; u < width; ++u) {
            const Eigen::Vector2d x = inverse * (Eigen::Vector2d(u, v) - c - shift) + c;
            image.set(u, v, gain * texture.at(x.x(), x.y()) + offset);
        }
    }
    return image;
}

/// Plane n . p = d of the world with a texture (wavelengths in metres) along two axes in it.
struct Plane {
    Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
    double distance = 3.0;

    Eigen::Vector3d intersect(const Eigen::Vector3d& origin, const Eigen::Vector3d& ray) const {
        return origin + ray * ((distance - normal.dot(origin)) / normal.dot(ray));
    }
};

/// What a distorted camera at T_W_C sees of the plane.
inline Image render(const Plane& plane, const Texture& texture, const CameraModel& camera, const Se3& T_W_C) {
    const CameraIntrinsics& k = camera.intrinsics();
    Image image(k.width, k.height);
    for (int v = 0; v < k.height; ++v) {
        for (int u = 0; u < k.width; ++u) {
            Eigen::Vector2d xy;
            if (ok(camera.unproject(Eigen::Vector2d(u, v), xy))) {
                const Eigen::Vector3d p = plane.intersect(T_W_C.p, T_W_C.q * xy.homogeneous());
                image.set(u, v, texture.at(p.x(), p.y()));
            }
        }
    }
    return image;
}

/// Half-size version of a common stereo-inertial sensor: two distorted 320x240 cameras, 11 cm apart, slightly turned.
inline StereoRig make_rig() {
    const CameraIntrinsics left{
        320, 240, 200.0, 199.0, 158.3, 121.2, Distortion::kRadialTangential, {-0.283, 0.074, 0.0002, 0.00002}};
    const CameraIntrinsics right{
        320, 240, 199.5, 198.6, 161.7, 118.9, Distortion::kRadialTangential, {-0.284, 0.0745, -0.0001, -0.00004}};
    StereoRig rig{CameraModel(left), CameraModel(right), {}, {}};
    rig.T_B_C0 = {so3_exp({0.02, -0.01, 1.55}), {-0.02, -0.06, 0.01}};
    rig.T_B_C1 = {rig.T_B_C0.q * so3_exp({0.005, 0.01, -0.004}), rig.T_B_C0 * Eigen::Vector3d(0.11, 0.001, -0.002)};
    return rig;
}

}  // namespace facet::synthetic
