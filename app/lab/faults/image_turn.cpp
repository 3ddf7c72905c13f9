// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/faults/image_turn.h"

#include <algorithm>
#include <cmath>

#include "estimator/geometry/so3.h"

namespace facet {
namespace {

/// Grey value between four pixels.
std::uint8_t between(const GreyImage& image, const Eigen::Vector2d& uv) {
    const double u = std::clamp(uv.x(), 0.0, image.width - 1.0);
    const double v = std::clamp(uv.y(), 0.0, image.height - 1.0);
    const int u0 = std::min(static_cast<int>(u), image.width - 2);
    const int v0 = std::min(static_cast<int>(v), image.height - 2);
    const double a = u - u0;
    const double b = v - v0;
    const std::uint8_t* upper = image.pixels.data() + static_cast<std::ptrdiff_t>(v0) * image.width + u0;
    const std::uint8_t* lower = upper + image.width;
    const double grey = (1.0 - b) * ((1.0 - a) * upper[0] + a * upper[1]) + b * ((1.0 - a) * lower[0] + a * lower[1]);
    return static_cast<std::uint8_t>(std::lround(grey));
}

}  // namespace

ImageTurn::ImageTurn(const CameraModel& camera, const Eigen::Quaterniond& R_B_C) : camera_(camera), R_B_C_(R_B_C) {
    const CameraIntrinsics& k = camera.intrinsics();
    rays_.reserve(static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height));
    for (int v = 0; v < k.height; ++v) {
        for (int u = 0; u < k.width; ++u) {
            Eigen::Vector2d xy;
            const bool is_seen = camera.in_lens({u, v}, 0.0) && ok(camera.unproject({u, v}, xy));
            rays_.emplace_back(Eigen::Vector3d::Zero());
            if (is_seen) {
                rays_.back() = xy.homogeneous();
            }
        }
    }
}

void ImageTurn::apply(const Eigen::Vector3d& theta_B, GreyImage& image) {
    if (image.pixels.size() != rays_.size() || image.width != camera_.intrinsics().width || image.width < 2 ||
        image.height < 2) {
        return;
    }
    before_ = image;
    const Eigen::Matrix3d turn = (R_B_C_.conjugate() * so3_exp(theta_B) * R_B_C_).toRotationMatrix();
    for (std::size_t i = 0; i < rays_.size(); ++i) {
        Eigen::Vector2d uv;
        if (ok(camera_.project(turn * rays_[i], uv))) {  // not so for a ray of zero
            image.pixels[i] = between(before_, uv);
        }
    }
}

}  // namespace facet
