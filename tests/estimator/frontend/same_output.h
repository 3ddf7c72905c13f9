// SPDX-License-Identifier: BSD-2-Clause
// Whether two runs of the front-end gave the same.
#pragma once

#include <cstring>

#include "estimator/frontend/frontend_types.h"

namespace facet::test {

/// All that counts, to the bit.
inline bool same(const FrontendOutput& a, const FrontendOutput& b) {
    if (a.stamp != b.stamp || a.is_keyframe != b.is_keyframe || a.is_still != b.is_still || a.tracked != b.tracked ||
        a.lost != b.lost || a.outliers != b.outliers || a.detected != b.detected || a.stereo != b.stereo ||
        std::memcmp(&a.median_disparity_px, &b.median_disparity_px, sizeof(double)) != 0 ||
        a.observations.size() != b.observations.size() || a.surface.size() != b.surface.size()) {
        return false;
    }
    for (std::size_t i = 0; i < a.surface.size(); ++i) {
        if (a.surface[i].landmark != b.surface[i].landmark || a.surface[i].right_xy != b.surface[i].right_xy) {
            return false;
        }
    }
    for (std::size_t i = 0; i < a.observations.size(); ++i) {
        const FeatureObservation& p = a.observations[i];
        const FeatureObservation& q = b.observations[i];
        if (p.landmark != q.landmark || p.left_xy != q.left_xy || p.right_xy != q.right_xy || p.left_px != q.left_px ||
            p.right_px != q.right_px || p.has_right != q.has_right || p.age_frames != q.age_frames) {
            return false;
        }
    }
    return true;
}

}  // namespace facet::test
