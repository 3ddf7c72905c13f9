// SPDX-License-Identifier: BSD-2-Clause
// A look at the first images of a log, for mistakes with which an estimator would go on and be wrong.
#pragma once

#include <vector>

#include "app/lab/check/free_matches.h"
#include "app/lab/check/verdict.h"
#include "estimator/geometry/stereo_rig.h"
#include "platform/base/samples.h"

namespace facet {

/// Matches a few of the first stereo pairs and applies check_same_image() and check_stereo(): one camera recorded
/// twice; images, calibrations, lenses or poses exchanged; poses inverted. Costs as much as one or two dozen frames of
/// the estimator. Thread-bound. Heap.
class StartCheck {
public:
    explicit StartCheck(const StereoRig& rig);

    /// @return what is wrong, at the frame with which that is known; nothing at all others, and if nothing is
    std::vector<CheckVerdict> add(const StereoFrame& frame);

private:
    static constexpr int kStride = 5;  ///< frames from one that is looked at to the next
    static constexpr int kLooks = 3;   ///< so many at most

    StereoRig rig_;
    FreeMatcher matcher_;
    int frames_ = 0;
    int looks_ = 0;  ///< kLooks: it has been reported, or cannot be
    std::vector<double> differences_;
    double brightest_mean_ = 0.0;
    std::vector<PointPair> pairs_;
};

}  // namespace facet
