// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/volume/depth_samples.h"

#include <algorithm>
#include <cmath>

#include "platform/base/assert.h"

namespace facet {
namespace {

// Least change of grey along the epipolar line of a pixel to be matched (1/px): half of what the grid asks for, since
// every depth is compared with other views.
constexpr float kMinGradient = 2.0F;
constexpr double kMinRho = 0.08;     // 1/m: what is farther is no depth
constexpr double kMinRate = 20.0;    // px m: of motion, below which it tells nothing that stereo did not
constexpr double kPosePx = 0.2;      // px: what the poses of two keyframes add
constexpr double kMorePx = 2.0;      // px searched beyond the sample's own doubt
constexpr double kSameSigmas = 3.0;  // within which two depths agree

}  // namespace

DepthSampler::DepthSampler(const StereoRig& rig, int side_px) : rig_(rig), side_(side_px) {
    stereo_.configure(rig);
    motion_.configure({rig.left, rig.left, Se3{}, Se3{}});
    columns_ = rig.left.intrinsics().width / side_;
    rows_ = rig.left.intrinsics().height / side_;
    for (int i = 0; i < columns_ * rows_; ++i) {
        const Eigen::Vector2i square(i % columns_, i / columns_);
        directions_.push_back(stereo_.epipolar_direction((square.cast<double>().array() + 0.5) * side_));
    }
}

bool DepthSampler::find_pixel(int square, const ImagePyramid& left, DepthSample& sample) const {
    const ImageView image = left.level(0);
    const int border = DepthMatcher::kReach_px + 2;
    const int u0 = square % columns_ * side_;
    const int v0 = square / columns_ * side_;
    const Eigen::Vector2f& direction = directions_[static_cast<std::size_t>(square)];
    float best = kMinGradient;
    Eigen::Vector2f uv = Eigen::Vector2f::Zero();
    Eigen::Vector2f steepest = Eigen::Vector2f::Zero();
    bool is_found = false;
    for (int v = std::max(v0, border); v < std::min(v0 + side_, image.height - border); ++v) {
        for (int u = std::max(u0, border); u < std::min(u0 + side_, image.width - border); ++u) {
            const Eigen::Vector2f gradient(0.5F * static_cast<float>(image.at(u + 1, v) - image.at(u - 1, v)),
                                           0.5F * static_cast<float>(image.at(u, v + 1) - image.at(u, v - 1)));
            const float along = std::abs(gradient.dot(direction));
            if (along > best) {
                best = along;
                uv = {static_cast<float>(u), static_cast<float>(v)};
                steepest = gradient;
                is_found = true;
            }
        }
    }
    if (is_found) {
        sample.uv = uv;
        sample.gradient = steepest;
    }
    return is_found;
}

void DepthSampler::correct(const CameraCorrections& cameras) { stereo_.correct(cameras); }

DepthSample DepthSampler::measure(int square, const ImagePyramid& left, const ImagePyramid& right,
                                  const Mesher* mesher) {
    DepthSample sample;
    DepthMatcher::Ray ray;
    Eigen::Vector2d xy;
    if (find_pixel(square, left, sample) && ok(stereo_.ray_of(sample.uv.cast<double>(), ray, xy))) {
        (void)match(left, right, mesher == nullptr ? all_depths() : stereo_.range_about(*mesher, xy, kMinDepth_m),
                    sample);
    }
    return sample;
}

bool DepthSampler::match(const ImagePyramid& left, const ImagePyramid& right, const DepthRange& range,
                         DepthSample& sample) {
    DepthMatcher::Ray ray;
    Eigen::Vector2d xy;
    DepthMatch match;
    if (!ok(stereo_.ray_of(sample.uv.cast<double>(), ray, xy)) ||
        stereo_.match(left.pairs(0), right.pairs(0), ray, sample.gradient, range, match) != DepthVerdict::kMatched ||
        match.inverse_depth <= kMinRho) {
        return false;
    }
    sample.xy = xy.cast<float>();
    sample.inverse_depth = static_cast<float>(match.inverse_depth);
    sample.sigma = static_cast<float>(match.sigma);
    return true;
}

void DepthSampler::face(const Se3& T_C_other, const CameraCorrections& cameras) {
    motion_.set_rig({rig_.left, rig_.left, Se3{}, T_C_other});
    CameraCorrections lenses;
    lenses.lens = {cameras.lens[0], cameras.lens[0]};
    motion_.correct(lenses);
    base_ = T_C_other.p;
}

void DepthSampler::compare(const ImagePyramid& own, const ImagePyramid& other, DepthSample& sample) {
    const auto rho = static_cast<double>(sample.inverse_depth);
    const auto sigma = static_cast<double>(sample.sigma);
    DepthMatcher::Ray ray;
    Eigen::Vector2d xy;
    const double rate = rig_.left.focal_px() * (base_.head<2>() - base_.z() * sample.xy.cast<double>()).norm();
    if (!(rho > 0.0) || !(rate >= kMinRate) || !ok(motion_.ray_of(sample.uv.cast<double>(), ray, xy))) {
        return;
    }
    const double reach = kSameSigmas * sigma + kMorePx / rate;
    DepthMatch match;
    if (motion_.match(own.pairs(0), other.pairs(0), ray, sample.gradient, {std::max(0.0, rho - reach), rho + reach},
                      match, DepthCheck::kOneWay) != DepthVerdict::kMatched) {
        return;
    }
    const double variance = match.sigma * match.sigma + kPosePx * kPosePx / (rate * rate);
    const double apart = match.inverse_depth - rho;
    if (apart * apart > kSameSigmas * kSameSigmas * (variance + sigma * sigma)) {
        ++sample.contradicted;
        return;
    }
    ++sample.confirmed;
    const double gain = sigma * sigma / (sigma * sigma + variance);
    sample.inverse_depth = static_cast<float>(rho + gain * apart);
    sample.sigma = static_cast<float>(sigma * std::sqrt(1.0 - gain));
}

}  // namespace facet
