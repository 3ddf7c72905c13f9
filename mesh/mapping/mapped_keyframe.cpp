// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/mapping/mapped_keyframe.h"

#include <algorithm>
#include <utility>

#include "platform/base/assert.h"

namespace facet {
namespace {

std::size_t size_of(const CameraModel& camera) {
    return static_cast<std::size_t>(camera.intrinsics().width) * static_cast<std::size_t>(camera.intrinsics().height);
}

/// @return the copy; empty if the image is
ImageView copy_into(std::vector<std::uint8_t>& pixels, const ImageView& image) {
    if (image.empty()) {
        return {};
    }
    const auto width = static_cast<std::size_t>(image.width);
    FACET_ASSERT(width * static_cast<std::size_t>(image.height) <= pixels.size());  // the estimator has taken it
    for (int v = 0; v < image.height; ++v) {
        std::copy_n(image.row(v), width, pixels.data() + static_cast<std::size_t>(v) * width);
    }
    return {pixels.data(), image.width, image.height, image.width};
}

}  // namespace

void KeptKeyframe::configure(const StereoRig& rig) {
    const std::size_t size = std::max(size_of(rig.left), size_of(rig.right));  // they may exchange their roles
    for (Pair& pair : pairs_) {
        pair.left.resize(size);
        pair.right.resize(size);
    }
    keyframe_ = {};
    is_set_ = false;
}

void KeptKeyframe::keep(const MappedKeyframe& keyframe) {
    std::swap(pairs_[0], pairs_[1]);
    keyframe_ = keyframe;
    keyframe_.frame.left = copy_into(pairs_[0].left, keyframe.frame.left);
    keyframe_.frame.right = copy_into(pairs_[0].right, keyframe.frame.right);
    is_set_ = true;
}

}  // namespace facet
