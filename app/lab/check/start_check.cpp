// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/check/start_check.h"

#include <algorithm>

#include "app/lab/check/stereo_check.h"

namespace facet {
namespace {

constexpr std::size_t kEnoughPairs = 60;

}  // namespace

StartCheck::StartCheck(const StereoRig& rig) : rig_(rig) {
    const CameraIntrinsics& left = rig.left.intrinsics();
    const CameraIntrinsics& right = rig.right.intrinsics();
    const bool is_one_size = rig.has_right && left.width == right.width && left.height == right.height;
    if (!is_one_size || !ok(matcher_.configure(left.width, left.height))) {
        looks_ = kLooks;
    }
}

std::vector<CheckVerdict> StartCheck::add(const StereoFrame& frame) {
    if (looks_ == kLooks || frame.left.empty() || frame.right.empty() || frames_++ % kStride != 0) {
        return {};
    }
    ++looks_;
    differences_.push_back(mean_difference(frame.left, frame.right));
    brightest_mean_ = std::max(brightest_mean_, mean_grey(frame.left));
    const std::vector<PointPair> pairs = matcher_.match_stereo(frame.left, frame.right);
    pairs_.insert(pairs_.end(), pairs.begin(), pairs.end());
    if (looks_ < kLooks && pairs_.size() < kEnoughPairs) {
        return {};
    }
    looks_ = kLooks;
    std::vector<CheckVerdict> verdicts = check_stereo(rig_, pairs_);
    verdicts.insert(verdicts.begin(), check_same_image(differences_, brightest_mean_));
    std::erase_if(verdicts, [](const CheckVerdict& v) { return v.level != CheckLevel::kWrong; });
    return verdicts;
}

}  // namespace facet
