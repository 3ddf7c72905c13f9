// SPDX-License-Identifier: BSD-2-Clause
// What the window holds: keyframes, landmarks and the prior. Plain data; the algorithms stand beside it.
#pragma once

#include <boost/container/static_vector.hpp>

#include "estimator/factors/imu_factor.h"
#include "estimator/factors/prior_factor.h"
#include "estimator/factors/stereo_factor.h"
#include "estimator/values/capacity.h"
#include "estimator/values/nav_state.h"
#include "estimator/window/landmark_store.h"
#include "estimator/window/rig_calibration.h"
#include "estimator/window/window_plane.h"
#include "platform/base/timestamp.h"

namespace facet {

/// One keyframe. The stamp is the image's plus the time offset estimated when it came; later corrections of the offset move
/// the cameras along `state`'s velocity and `w_B`. `state_lin` is where the prior counts from, if it covers the keyframe, and where first-estimate Jacobians
/// are taken once marginalization has bound it.
struct Keyframe {
    Timestamp stamp;
    NavState state;
    NavState state_lin;
    Eigen::Vector3d w_B = Eigen::Vector3d::Zero();  ///< rate at the stamp, bias taken off (rad/s)
    double time_offset_s = 0.0;                     ///< that is in the stamp
    bool is_bound = false;        ///< marginalization has used this keyframe: Jacobians stay at state_lin
    bool has_imu_factor = false;  ///< none for the oldest keyframe, nor where the prior has taken it in
    ImuFactor imu_from_previous;
    bool rests_since_previous = false;  ///< the vehicle stood still between the previous keyframe and this one

    const NavState& linearization_point() const { return is_bound ? state_lin : state; }
};

/// The window, oldest keyframe first. Several MB; never copied. Thread-bound. No heap.
struct WindowState {
    boost::container::static_vector<Keyframe, kMaxKeyframes> keyframes;
    LandmarkStore landmarks;
    WindowPlanes planes;
    PlanePairs plane_pairs;
    PriorFactor prior;  ///< over the calibration, the planes and the first keyframes
    RigCalibration calibration;
    RigCalibration calibration_lin;  ///< where the prior counts from

    /// Forgets what was seen; calibration and prior stay.
    void clear() {
        keyframes.clear();
        landmarks.clear();
        planes.clear();
        plane_pairs.clear();
    }

    /// How far calibration (its first parameters) and planes have moved from where the prior counts from.
    template <class Vector>
    void globals_displacement(int calibration_dim, Vector&& d) const {
        d.head(calibration_dim) = calibration_lin.box_minus_to(calibration).head(calibration_dim);
        for (std::size_t p = 0; p < planes.size(); ++p) {
            d.template segment<kPlaneDim>(calibration_dim + kPlaneDim * static_cast<int>(p)) =
                planes[p].is_bound ? planes[p].plane_lin.box_minus_to(planes[p].plane) : Plane::Tangent::Zero();
        }
    }
};

}  // namespace facet
