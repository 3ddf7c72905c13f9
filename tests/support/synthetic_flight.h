// SPDX-License-Identifier: BSD-2-Clause
// A closed-form flight among point landmarks: exact states, inertial samples and stereo observations for tests.
#pragma once

#include <random>
#include <vector>

#include "estimator/geometry/stereo_rig.h"
#include "estimator/imu/preintegration.h"
#include "estimator/values/imu_noise.h"
#include "estimator/values/nav_state.h"
#include "estimator/values/observation.h"
#include "estimator/values/planes.h"

namespace facet::test {

/// EuRoC-like rig: 11 cm baseline, cameras turned against the body, no distortion.
StereoRig make_rig();

/// White noise of an EuRoC-like IMU; bias walks as by default.
ImuNoise euroc_like_noise();

/// What a start at rest leaves uncertain, 1 sigma in the order of the state's tangent: tilt, a little yaw and position,
/// velocity, biases.
Eigen::Matrix<double, kStateDim, 1> start_sigmas();

/// A smooth periodic motion: angles and place swing with amplitudes of their own; a constant velocity comes on top.
struct SyntheticMotion {
    double yaw_rad = 0.8;
    double pitch_rad = 0.15;
    double roll_rad = 0.12;
    Eigen::Vector3d place_m{1.2, 0.9, 0.4};                      ///< x and z swing as a sine, y as 1 - cosine
    Eigen::Vector3d velocity_m_per_s = Eigen::Vector3d::Zero();  ///< constant
};

/// Smooth flight among landmarks on all sides. All derivatives are analytic.
class SyntheticFlight {
public:
    struct Options {
        double gyro_noise = 0.0;                  ///< rad/s/sqrt(Hz)
        double accel_noise = 0.0;                 ///< m/s^2/sqrt(Hz)
        double pixel_sigma = 0.0;                 ///< px
        ImuBias bias;                             ///< constant, added to the samples
        double gravity_m_per_s2 = 9.81;           ///< that the IMU feels
        double believed_gravity_m_per_s2 = 9.81;  ///< that preintegrate() is told
        double time_offset_s = 0.0;               ///< what must be added to an image's stamp to have the IMU's time
        Eigen::Vector3d rig_rotation = Eigen::Vector3d::Zero();  ///< true cameras = Exp(this) * rig() (rad)
        double imu_rate_hz = 200.0;
        int landmarks = 400;
        SyntheticMotion motion;
        bool in_room = false;  ///< landmarks on the walls, floor and ceiling of a room, else anywhere
        unsigned seed = 1;
    };

    explicit SyntheticFlight(const Options& options);

    /// True state at time t (s), bias included.
    NavState state(double t) const;
    /// True angular rate in B at time t (rad/s).
    Eigen::Vector3d rate(double t) const;
    /// Inertial sample at time t with fresh noise.
    ImuSample imu(double t);
    /// What both cameras see at time t, ids = landmark index; at most `most` landmarks.
    std::vector<FeatureObservation> observe(double t, int most = 150);
    /// Preintegration of samples from t0 to t1 at the given bias.
    Preintegration preintegrate(double t0, double t1, const ImuBias& bias, const ImuNoise& noise);

    /// The room's planes with all their landmarks, as the mesh would propose them: floor, ceiling and four walls, their
    /// normals pointing inwards.
    PlaneProposals planes() const;

    const std::vector<Eigen::Vector3d>& landmarks() const { return landmarks_; }
    const StereoRig& rig() const { return rig_; }

private:
    Eigen::Vector3d gaussian();
    Eigen::Vector3d acceleration(double t) const;

    Options options_;
    StereoRig rig_;  ///< as calibrated
    StereoRig true_rig_;
    std::vector<Eigen::Vector3d> landmarks_;
    std::mt19937 generator_;
};

inline Timestamp at(double t) { return {Duration::from_seconds(1000.0 + t).ns}; }

}  // namespace facet::test
