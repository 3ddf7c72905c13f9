// SPDX-License-Identifier: BSD-2-Clause
// What faulty cameras see.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <map>
#include <vector>

#include "app/lab/faults/fault_schedule.h"
#include "app/lab/faults/fault_vibration.h"
#include "app/lab/faults/image_turn.h"
#include "app/lab/faults/moving_board.h"
#include "app/lab/faults/owned_frame.h"
#include "estimator/geometry/stereo_rig.h"

namespace facet {

/// Changes images as the faults ask, on their way through the camera: the turning body (vibration); frozen pictures;
/// the scene (board, wall); the lens (smear); light (exposure, dark, flash); the sensor (noise, black); transport
/// (pairs apart, exchanged, missing). Deterministic: noise depends on the number of the frame only, vibration on the
/// log's stamp. Thread-bound. Heap: images of a freeze or of frames ago, tables of the board and of the cameras' rays.
class FrameFaults {
public:
    /// @param rig  the true one, for mover and vibration
    FrameFaults(FaultSchedule& schedule, const StereoRig& rig);

    /// @param number  of the frame in the log, from 1
    void change(OwnedFrame& frame, std::uint64_t number);

    /// Whether there is a vibration that images show.
    bool turns_images() const { return !turns_.empty(); }
    /// By how much a body that vibrates is turned at this time, where images show it (rad, about the axes of the IMU):
    /// its attitude is R Exp(angle) where it would be R. Fast for times in order.
    Eigen::Vector3d turn_at(Timestamp log_stamp);

private:
    /// For each active fault of this kind, apply(fault, image, seed) to the images of the cameras that it is of.
    /// @param camera_value  place of CAMERA among the fault's values
    template <class Apply>
    void for_images(FaultKind kind, std::size_t camera_value, OwnedFrame& frame, std::uint64_t number, Apply apply);
    void shake(OwnedFrame& frame);
    void freeze(OwnedFrame& frame);
    void change_scene(OwnedFrame& frame, std::uint64_t number);
    void change_light(OwnedFrame& frame, std::uint64_t number);
    void pair_with_earlier(OwnedFrame& frame);

    FaultSchedule& schedule_;
    StereoRig rig_;
    std::map<std::size_t, VibrationAngle> angles_;  ///< by fault, of those that images show
    std::vector<ImageTurn> turns_;                  ///< left, right; none unless images show a vibration
    std::map<std::size_t, OwnedFrame> frozen_;      ///< the first frame of the freeze under way, by fault
    std::map<std::size_t, MovingBoard> boards_;
    std::size_t longest_pair_off_ = 0;
    std::deque<GreyImage> earlier_right_;  ///< of the frames before, the newest last
};

}  // namespace facet
