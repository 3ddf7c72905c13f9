// SPDX-License-Identifier: BSD-2-Clause
// How every keyframe's cameras see every earlier keyframe's chart, computed once for all landmarks.
#pragma once

#include <array>

#include "estimator/factors/stereo_factor.h"
#include "estimator/values/capacity.h"

namespace facet {

/// Both cameras of a keyframe.
struct CameraPair {
    CameraPose left;
    CameraPose right;
};

/// Table of StereoView by keyframe and host, host <= keyframe: landmarks live in the chart of the left camera of the
/// first keyframe that saw them. 270 kB. Thread-bound. No heap.
class StereoViews {
public:
    /// Sets a row of the table: this keyframe's cameras relative to the left cameras of keyframes 0 to `keyframe`.
    void set(int keyframe, const CameraPair& cameras, const std::array<CameraPair, kMaxKeyframes>& hosts) {
        for (int host = 0; host <= keyframe; ++host) {
            const CameraPose& chart = hosts[static_cast<std::size_t>(host)].left;
            views_[index(keyframe, host)] = {RelativeView::of(cameras.left, chart),
                                             RelativeView::of(cameras.right, chart)};
        }
    }
    const StereoView& at(int keyframe, int host) const { return views_[index(keyframe, host)]; }

private:
    static std::size_t index(int keyframe, int host) {
        return static_cast<std::size_t>(keyframe * (keyframe + 1) / 2 + host);
    }
    std::array<StereoView, kMaxKeyframes*(kMaxKeyframes + 1) / 2> views_;
};

}  // namespace facet
