// SPDX-License-Identifier: BSD-2-Clause
#include <limits>

#include "app/lab/faults/fault.h"

namespace facet {
namespace {

constexpr double kNeeded = std::numeric_limits<double>::quiet_NaN();
const FaultValue kSeed{"SEED", 0.0, 4294967295.0, 1.0};
const FaultValue kCamera{"CAMERA", 0.0, 2.0, 0.0, {"both", "left", "right"}};
const FaultValue kPart{"PART", 0.0, 2.0, 0.0, {"both", "gyro", "accel"}};
const FaultValue kEach{"N", 2.0, 1000.0, 2.0};

/// Of what cameras see.
std::vector<FaultInfo> faults_of_images() {
    return {
        {FaultKind::kBlackout, "blackout", {kCamera}, "images black, with a little sensor noise"},
        {FaultKind::kFlash,
         "flash",
         {{"GAIN", 1.0, 255.0, 16.0}, kCamera},
         "images overexposed: pixels times GAIN, saturating"},
        {FaultKind::kDark,
         "dark",
         {{"GAIN", 0.0, 1.0, 0.05}, kCamera},
         "low light: pixels times GAIN, with sensor noise"},
        {FaultKind::kExposure,
         "exposure",
         {{"STOPS", 0.0, 8.0, 2.0}, kCamera},
         "exposure stuck while the light rises and falls by STOPS within 4 s"},
        {FaultKind::kImageNoise,
         "image_noise",
         {{"SIGMA", 0.0, 128.0, kNeeded}, kCamera},
         "white noise of SIGMA grey values added to every pixel"},
        {FaultKind::kSmear, "smear", {kCamera}, "a smear on the lens: a third of the image blurred and veiled"},
        {FaultKind::kWall, "wall", {kCamera}, "a wall without texture fills the image: one grey, with sensor noise"},
        {FaultKind::kMover,
         "mover",
         {{"SHARE", 0.01, 1.0, 0.6}, {"SPEED", -20.0, 20.0, 0.5}},
         "a textured board, 2 m ahead, covers SHARE of both images and slides to the right at SPEED m/s"},
        {FaultKind::kFreeze, "freeze", {kCamera}, "the first images are repeated with new stamps"},
        {FaultKind::kSwap, "swap", {}, "left and right images exchanged"},
        {FaultKind::kPairOff, "pair_off", {{"N", 1.0, 20.0, 1.0}}, "right images are those of N frames earlier"},
    };
}

/// Of which frames arrive, when, and under which stamps.
std::vector<FaultInfo> faults_of_frames() {
    return {
        {FaultKind::kNoLeft, "no_left", {}, "left images do not arrive"},
        {FaultKind::kNoRight, "no_right", {}, "right images do not arrive"},
        {FaultKind::kDropFrames,
         "drop_frames",
         {{"SHARE", 0.0, 1.0, kNeeded}, kSeed},
         "stereo frames lost at random with probability SHARE"},
        {FaultKind::kFrameThin, "frame_thin", {kEach}, "only each N-th frame arrives"},
        {FaultKind::kFrameDuplicate,
         "frame_duplicate",
         {{"SHARE", 0.0, 1.0, 1.0}},
         "frames delivered twice with probability SHARE"},
        {FaultKind::kFrameOrder, "frame_order", {}, "each second frame arrives before the one ahead of it"},
        {FaultKind::kFrameJump,
         "frame_jump",
         {{"SECONDS", -1e4, 1e4, kNeeded}},
         "stamps of images shifted, those of the IMU not; the trajectory is written with the log's stamps"},
        {FaultKind::kTimeOffset,
         "time_offset",
         {{"SECONDS", -1.0, 1.0, kNeeded}},
         "image stamps shifted against the inertial ones; it is up to the estimator to find that"},
        {FaultKind::kClockJump,
         "clock_jump",
         {{"SECONDS", -1e4, 1e4, kNeeded}},
         "all stamps shifted; the trajectory is written with the log's stamps"},
    };
}

/// Of which inertial samples arrive, and when.
std::vector<FaultInfo> faults_of_inertial_stream() {
    return {
        {FaultKind::kImuGap, "imu_gap", {}, "inertial samples missing"},
        {FaultKind::kImuThin, "imu_thin", {kEach}, "only each N-th inertial sample arrives"},
        {FaultKind::kImuDuplicate,
         "imu_duplicate",
         {{"SHARE", 0.0, 1.0, 1.0}},
         "inertial samples delivered twice with probability SHARE"},
        {FaultKind::kImuOrder, "imu_order", {}, "each second inertial sample arrives before the one ahead of it"},
        {FaultKind::kImuJump,
         "imu_jump",
         {{"SECONDS", -1e4, 1e4, kNeeded}},
         "stamps of the inertial samples shifted, those of images not"},
    };
}

/// Of what inertial samples say.
std::vector<FaultInfo> faults_of_inertial_values() {
    return {
        {FaultKind::kImuClip,
         "clip",
         {{"ACCEL", 0.0, 1e4, 160.0}, {"GYRO", 0.0, 1e3, 17.0}, kPart},
         "accelerometer (m/s^2) and gyroscope (rad/s) at full scale, signs + - + on x y z"},
        {FaultKind::kImuFreeze, "imu_freeze", {kPart}, "the first readings are repeated"},
        {FaultKind::kImuZero, "imu_zero", {kPart}, "readings are all zero"},
        {FaultKind::kImuNan, "imu_nan", {{"SHARE", 0.0, 1.0, 1.0}, kPart}, "NaN with probability SHARE"},
        {FaultKind::kImuAxes,
         "imu_axes",
         {{"KIND", 0.0, 2.0, 0.0, {"cycle", "turn", "mirror"}}},
         "wrong axes: x y z read y z x; turned by 180 degrees about z; or y mirrored"},
        {FaultKind::kImuNoise,
         "imu_noise",
         {{"FACTOR", 0.0, 1e4, kNeeded}, kPart},
         "white noise of FACTOR times the calibrated density added to the inertial samples"},
        {FaultKind::kImuBias,
         "imu_bias",
         {{"FACTOR", 0.0, 1e4, 1.0}, kSeed},
         "FACTOR times a bias of about 0.03 rad/s and 0.06 m/s^2 that walks as calibrated"},
        {FaultKind::kImuScale,
         "imu_scale",
         {{"FACTOR", 0.0, 20.0, 1.0}, kSeed},
         "the IMU's axes wrong by FACTOR times what a data sheet allows: 0.5 % of scale, 5 mrad of misalignment"},
        {FaultKind::kVibration,
         "vibration",
         {{"KIND", 0.0, 1.0, kNeeded, {"idle", "flight"}},
          kSeed,
          {"FACTOR", 0.0, 100.0, 1.0},
          {"SHOWN", 0.0, 1.0, 0.0, {"samples", "images"}}},
         "FACTOR times a real drone's rotor vibration in the inertial samples, KIND idle or flight; SHOWN images: "
         "images rotate with it"},
    };
}

}  // namespace

const std::vector<FaultInfo>& fault_table() {
    static const std::vector<FaultInfo> kTable = [] {
        std::vector<FaultInfo> all = faults_of_images();
        for (const auto& more : {faults_of_frames(), faults_of_inertial_stream(), faults_of_inertial_values()}) {
            all.insert(all.end(), more.begin(), more.end());
        }
        all.push_back({FaultKind::kCalibration,
                       "calibration",
                       {{"K", 0.0, 100.0, 1.0}, kSeed, {"DRAW", 0.0, 1.0, 0.0, {"normal", "tails"}}},
                       "both cameras' calibration perturbed by K sigma of a good one; DRAW tails: each "
                       "parameter by Student's t with three degrees of freedom",
                       true});
        return all;
    }();
    return kTable;
}

}  // namespace facet
