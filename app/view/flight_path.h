// SPDX-License-Identifier: BSD-2-Clause
// The path of a flight as Foxglove is shown it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "app/view/view_snapshot.h"

namespace facet {

/// Poses at keyframes since the estimator began, or restarted; the newest kMostPoses. Thread-bound. Heap.
class FlightPath {
public:
    static constexpr std::size_t kMostPoses = 500;

    void add(const ViewState& keyframe) {
        if (keyframe.health.reset_counter != resets_) {
            resets_ = keyframe.health.reset_counter;
            poses_.clear();
        }
        if (poses_.size() == kMostPoses) {
            poses_.erase(poses_.begin());
        }
        poses_.push_back(keyframe.T_W_B);
    }
    std::span<const Se3> poses() const { return poses_; }

private:
    std::vector<Se3> poses_;
    std::uint32_t resets_ = 0;  ///< the estimator's reset counter along the path
};

}  // namespace facet
