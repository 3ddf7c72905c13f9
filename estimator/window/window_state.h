// SPDX-License-Identifier: BSD-2-Clause
// The contents of the window: keyframes, landmarks and the prior. Plain data; the algorithms are elsewhere.
#pragma once

#include <array>
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

/// What a range finder has found under a keyframe.
struct GroundReading {
    static constexpr int kNone = -1;
    int level = kNone;                              ///< which of WindowState::ground; kNone: there is no reading
    Eigen::Vector3d p_B = Eigen::Vector3d::Zero();  ///< a point of the ground, in B (m)
};

/// A level of the ground: its height is a variable of the window, linear in all that knows of it.
struct GroundLevel {
    bool is_known = false;                              ///< there have been readings of it
    double height_m = 0.0;                              ///< in W
    double height_lin_m = 0.0;                          ///< that the prior refers to
    Timestamp last;                                     ///< stamp of its newest reading
    Eigen::Vector2d place_m = Eigen::Vector2d::Zero();  ///< where that was, in W
};

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
    GroundReading ground;

    const NavState& linearization_point() const { return is_bound ? state_lin : state; }
};

/// The window, oldest keyframe first. Several MB; never copied. Thread-bound. No heap.
struct WindowState {
    boost::container::static_vector<Keyframe, kMaxKeyframes> keyframes;
    LandmarkStore landmarks;
    std::array<GroundLevel, PriorFactor::kMaxGround> ground;
    bool has_ground = false;  ///< these are variables
    WindowPlanes planes;
    PriorFactor prior;  ///< over the calibration, the ground, the planes and the first keyframes
    RigCalibration calibration;
    RigCalibration calibration_lin;  ///< the calibration that the prior refers to
    /// Information about no correction at all, from the calibration as given; zero where the prior contains it.
    CalibrationMatrix given;

    /// Parameters of the ground, behind those of the calibration.
    int ground_dim() const { return has_ground ? PriorFactor::kMaxGround : 0; }

    /// Forgets keyframes, landmarks, ground and planes; calibration, what was given of it and prior are kept.
    void clear() {
        keyframes.clear();
        landmarks.clear();
        planes.clear();
        ground = {};
    }

    /// Displacement of the calibration (its first parameters), the ground and the planes from the points that the prior
    /// refers to. @param first_plane  row of the first plane
    template <class Vector>
    void globals_displacement(int first_plane, Vector&& d) const {
        const int calibration_dim = first_plane - ground_dim();
        d.head(calibration_dim) = calibration_lin.box_minus_to(calibration).head(calibration_dim);
        for (int l = 0; l < ground_dim(); ++l) {
            const GroundLevel& level = ground[static_cast<std::size_t>(l)];
            d(calibration_dim + l) = level.height_m - level.height_lin_m;
        }
        for (std::size_t p = 0; p < planes.size(); ++p) {
            d.template segment<kPlaneDim>(first_plane + kPlaneDim * static_cast<int>(p)) =
                planes[p].is_bound ? planes[p].plane_lin.box_minus_to(planes[p].plane) : Plane::Tangent::Zero();
        }
    }
};

}  // namespace facet
