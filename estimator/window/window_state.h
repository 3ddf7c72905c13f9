// SPDX-License-Identifier: BSD-2-Clause
// What the window holds: keyframes, landmarks and the prior. Plain data; the algorithms stand beside it.
#pragma once

#include <boost/container/static_vector.hpp>

#include "estimator/api/capacity.h"
#include "estimator/factors/imu_factor.h"
#include "estimator/factors/prior_factor.h"
#include "estimator/factors/stereo_factor.h"
#include "estimator/window/landmark_store.h"
#include "platform/base/timestamp.h"

namespace facet {

/// One keyframe. `state_lin` is where the prior counts from, if it covers the keyframe, and where first-estimate Jacobians
/// are taken once marginalization has bound it.
struct Keyframe {
    Timestamp stamp;
    NavState state;
    NavState state_lin;
    bool is_bound = false;        ///< marginalization has used this keyframe: Jacobians stay at state_lin
    ImuFactor imu_from_previous;  ///< not set for the oldest keyframe

    const NavState& linearization_point() const { return is_bound ? state_lin : state; }
};

/// The window, oldest keyframe first. Several MB; never copied. Thread-bound. No heap.
struct WindowState {
    boost::container::static_vector<Keyframe, kMaxKeyframes> keyframes;
    LandmarkStore landmarks;
    PriorFactor prior;
};

}  // namespace facet
