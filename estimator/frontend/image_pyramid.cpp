// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/image_pyramid.h"

#include <opencv2/imgproc.hpp>

#include "platform/base/assert.h"

namespace facet {
namespace {

constexpr int kMinSide = 16;

/// Header over a level's pixels. OpenCV has no read-only matrix: the caller keeps to reading where it must.
cv::Mat mat_of(const ImageView& view) {
    return {view.height, view.width, CV_8UC1, const_cast<std::uint8_t*>(view.data),
            static_cast<std::size_t>(view.stride)};
}

}  // namespace

Status ImagePyramid::configure(int width, int height, int levels) {
    if (levels < 1 || levels > kMaxLevels || (width >> (levels - 1)) < kMinSide ||
        (height >> (levels - 1)) < kMinSide) {
        return Status::kInvalidArgument;
    }
    levels_ = levels;
    for (int l = 0; l < levels; ++l) {
        auto& buffer = buffers_[static_cast<std::size_t>(l)];
        buffer.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0);
        views_[static_cast<std::size_t>(l)] = {buffer.data(), width, height, width};
        width = (width + 1) / 2;
        height = (height + 1) / 2;
    }
    return Status::kOk;
}

void ImagePyramid::build(const ImageView& image) {
    FACET_ASSERT(levels_ > 0 && image.width == views_[0].width && image.height == views_[0].height);
    const cv::Mat source = mat_of(image);
    cv::Mat previous = mat_of(views_[0]);
    source.copyTo(previous);
    for (int l = 1; l < levels_; ++l) {
        cv::Mat next = mat_of(level(l));
        cv::pyrDown(previous, next, next.size());
        previous = next;
    }
}

}  // namespace facet
