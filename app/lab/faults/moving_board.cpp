// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/faults/moving_board.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "app/support/rng.h"

namespace facet {
namespace {

/// Random grey in [0, 1) at the corners of a lattice, bilinear between them.
float value_noise(float x, float y, std::uint64_t seed) {
    const float fx = std::floor(x);
    const float fy = std::floor(y);
    const auto corner = [&](int i, int j) {
        const auto a = static_cast<std::uint64_t>(static_cast<std::int64_t>(fx) + i);
        const auto b = static_cast<std::uint64_t>(static_cast<std::int64_t>(fy) + j);
        return static_cast<float>(hash64(seed, a, b) >> 40) * 0x1.0p-24F;
    };
    const float u = x - fx;
    const float v = y - fy;
    return (1.0F - v) * ((1.0F - u) * corner(0, 0) + u * corner(1, 0)) +
           v * ((1.0F - u) * corner(0, 1) + u * corner(1, 1));
}

/// Patches of 12 cm with detail of 3 cm: some 30 and 7 px of EuRoC's cameras.
std::uint8_t texture(float x_m, float y_m) {
    const float coarse = value_noise(x_m / 0.12F, y_m / 0.12F, 1);
    const float fine = value_noise(x_m / 0.03F, y_m / 0.03F, 2);
    return static_cast<std::uint8_t>(30.0F + 110.0F * coarse + 90.0F * fine);
}

}  // namespace

MovingBoard::MovingBoard(const StereoRig& rig, double share) {
    const CameraIntrinsics& k = rig.left.intrinsics();
    const double scale = kDistance_m * 0.5 * std::sqrt(share);
    const double half_x_m = scale * k.width / k.fx;
    const double half_y_m = scale * k.height / k.fy;
    sizes_[0] = static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height);
    pixels_[0] = pixels_of(rig.left, Se3{}, half_x_m, half_y_m);
    if (rig.has_right) {
        const CameraIntrinsics& right = rig.right.intrinsics();
        sizes_[1] = static_cast<std::size_t>(right.width) * static_cast<std::size_t>(right.height);
        pixels_[1] = pixels_of(rig.right, rig.T_C1_C0().inverse(), half_x_m, half_y_m);
    }
}

std::vector<MovingBoard::Pixel> MovingBoard::pixels_of(const CameraModel& camera, const Se3& T_C0_C, double half_x_m,
                                                       double half_y_m) {
    std::vector<Pixel> pixels;
    const CameraIntrinsics& k = camera.intrinsics();
    for (int v = 0; v < k.height; ++v) {
        for (int u = 0; u < k.width; ++u) {
            Eigen::Vector2d xy;
            if (!ok(camera.unproject({u, v}, xy))) {
                continue;
            }
            const Eigen::Vector3d ray = T_C0_C.q * Eigen::Vector3d(xy.x(), xy.y(), 1.0);
            const double length = (kDistance_m - T_C0_C.p.z()) / ray.z();
            const Eigen::Vector3d p = T_C0_C.p + length * ray;
            if (ray.z() > 0.0 && length > 0.0 && std::abs(p.x()) < half_x_m && std::abs(p.y()) < half_y_m) {
                pixels.push_back({.index = static_cast<std::uint32_t>(v * k.width + u),
                                  .x_m = static_cast<float>(p.x()),
                                  .y_m = static_cast<float>(p.y())});
            }
        }
    }
    return pixels;
}

void MovingBoard::draw(bool is_right, double shift_m, GreyImage& image) const {
    const std::size_t side = is_right ? 1 : 0;
    if (image.pixels.size() != sizes_[side]) {
        return;
    }
    const auto shift = static_cast<float>(shift_m);
    for (const Pixel& pixel : pixels_[side]) {
        image.pixels[pixel.index] = texture(pixel.x_m - shift, pixel.y_m);
    }
}

}  // namespace facet
