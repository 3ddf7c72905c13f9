// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/replay/waiting_frames.h"

#include "app/lab/faults/image_faults.h"
#include "app/lab/replay/replay.h"

namespace facet {
namespace {

constexpr std::size_t kMaxWaiting = 256;  // frames: more than a second of a fast camera, 180 MB of EuRoC's

}  // namespace

void WaitingFrames::add(const StereoFrame& frame, Timestamp output_stamp) {
    if (spare_.empty()) {
        spare_.emplace_back();
    }
    waiting_.splice(waiting_.end(), spare_, spare_.begin());
    OwnedFrame& kept = waiting_.back();
    kept.stamp = frame.stamp;
    kept.output_stamp = output_stamp;
    kept.has_left = !frame.left.empty();
    kept.has_right = !frame.right.empty();
    copy_image(frame.left, kept.left);
    copy_image(frame.right, kept.right);
}

bool WaitingFrames::is_overdue() const {
    if (waiting_.empty()) {
        return false;
    }
    const Duration apart = waiting_.back().stamp - waiting_.front().stamp;
    return waiting_.size() > kMaxWaiting || apart > kRetry || apart < Duration{-kRetry.ns};
}

}  // namespace facet
