// SPDX-License-Identifier: BSD-2-Clause
// The contents of the window: keyframes, landmarks and the prior. Plain data; the algorithms are elsewhere.
#pragma once

#include <boost/container/static_vector.hpp>

#include "estimator/factors/imu_factor.h"
#include "estimator/factors/prior_factor.h"
#include "estimator/factors/stereo_factor.h"
#include "estimator/values/capacity.h"
#include "estimator/values/nav_state.h"
#include "estimator/window/calibration_prior.h"
#include "estimator/window/landmark_store.h"
#include "estimator/window/rig_calibration.h"
#include "estimator/window/window_plane.h"
#include "platform/base/timestamp.h"

namespace facet {

/// One keyframe. The stamp is the image's plus the time offset estimated when the keyframe was added; later corrections
/// of the offset move the cameras along `state`'s velocity and `w_B`. `state_lin` is the state that the prior refers
/// to, if the prior covers the keyframe, and the point of first-estimate Jacobians once marginalization has bound the
/// keyframe.
struct Keyframe {
    Timestamp stamp;
    NavState state;
    NavState state_lin;
    Eigen::Vector3d w_B = Eigen::Vector3d::Zero();  ///< rate at the stamp, bias subtracted (rad/s)
    double time_offset_s = 0.0;                     ///< the offset contained in the stamp
    bool is_bound = false;        ///< marginalization has used this keyframe: Jacobians stay at state_lin
    bool has_imu_factor = false;  ///< false for the oldest keyframe, and if the prior has absorbed it
    ImuFactor imu_from_previous;
    bool rests_since_previous = false;  ///< the vehicle stood still between the previous keyframe and this one

    const NavState& linearization_point() const { return is_bound ? state_lin : state; }
};

/// The window, oldest keyframe first. Several MB; never copied. Thread-bound. No heap.
struct WindowState {
    boost::container::static_vector<Keyframe, kMaxKeyframes> keyframes;
    LandmarkStore landmarks;
    WindowPlanes planes;
    PriorFactor prior;  ///< over the calibration, the planes and the first keyframes
    RigCalibration calibration;
    RigCalibration calibration_lin;  ///< the calibration that the prior refers to
    /// Information about no correction at all, from the calibration as given; zero where the prior contains it.
    CalibrationMatrix given;

    /// Forgets keyframes, landmarks and planes; calibration, what was given of it and prior are kept.
    void clear() {
        keyframes.clear();
        landmarks.clear();
        planes.clear();
    }

    /// Displacement of the calibration (its first parameters) and the planes from the points that the prior refers to.
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
