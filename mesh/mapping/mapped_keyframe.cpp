// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/mapping/mapped_keyframe.h"

#include <algorithm>
#include <utility>

#include "platform/base/assert.h"
#include "platform/base/image_copy.h"

namespace facet {
namespace {

std::size_t size_of(const CameraModel& camera) {
    return static_cast<std::size_t>(camera.intrinsics().width) * static_cast<std::size_t>(camera.intrinsics().height);
}

/// @return the copy; empty if the image is
ImageView copy_into(std::vector<std::uint8_t>& pixels, const ImageView& image) {
    // The estimator has taken the image: it has the rig's size.
    FACET_ASSERT(image.empty() ||
                 static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) <= pixels.size());
    return copy_pixels(image, pixels.data());
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
