// SPDX-License-Identifier: BSD-2-Clause
// What the sinks are given: the newest estimate, carried on to inertial samples, at a rate of its own.
#pragma once

#include <optional>

#include "app/config/vehicle.h"
#include "app/pipeline/carried_estimate.h"
#include "mesh/places/yaw_pose.h"
#include "platform/port/odometry_sink.h"

namespace facet {

/// What became of a frame, or what is said while none comes, as far as sinks are concerned.
struct FrameOutcome {
    Status status = Status::kOk;
    bool has_frame = true;
    Timestamp frame_stamp;
    Estimate estimate;
    Belief belief;                                  ///< the pipeline's
    Eigen::Vector3d w_B = Eigen::Vector3d::Zero();  ///< newest angular rate given to the estimator, bias in it
    std::optional<YawPose> T_M_W = std::nullopt;    ///< from W to the map of places, while the pose in it is known
};

/// Makes odometry of inertial samples and frames. Stamps are those of the samples and only increase: a correction by a
/// frame is seen from the next sample on. At most one value a sample. At rate 0 it is one value a frame instead, at the
/// instant of its exposure. Nothing comes before the start; being lost comes as quality -1. Usage:
///   if (stream.add_imu(sample, odometry)) send(odometry);       // every sample, at once
///   if (stream.add_frame(outcome, odometry)) send(odometry);    // every frame, once the samples before it are added
/// Thread-bound. About 560 kB: on the heap or static. No heap itself.
class OdometryStream {
public:
    OdometryStream(const ProgramConfig& config, const VehicleOdometry& options);

    /// @return whether there is a value to send (odometry untouched otherwise)
    bool add_imu(const ImuSample& sample, Odometry& odometry);
    bool add_frame(const FrameOutcome& outcome, Odometry& odometry);

private:
    bool is_due(Timestamp stamp);
    Odometry odometry_of(const Estimate& estimate, const Eigen::Vector3d& w_B) const;

    ImuNoise noise_;
    Se3 T_body_imu_;
    CarriedEstimate carried_;
    std::optional<YawPose> T_M_W_;  ///< of the newest frame
    bool is_by_frame_;
    Duration period_;
    Duration tolerance_;  ///< half a period of the IMU: the sample nearest to the due instant is taken
    bool any_ = false;
    Timestamp due_;
};

}  // namespace facet
