// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/faults/frame_faults.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "app/lab/faults/image_faults.h"

namespace facet {
namespace {

constexpr double kDarkNoise = 1.5;      // grey values
constexpr double kLightPeriod_s = 4.0;  // of kExposure

bool is_of(FaultCamera camera, bool is_right) {
    return camera == FaultCamera::kBoth || (camera == FaultCamera::kRight) == is_right;
}

}  // namespace

FrameFaults::FrameFaults(FaultSchedule& schedule, const StereoRig& rig) : schedule_(schedule), rig_(rig) {
    schedule_.for_all(FaultKind::kPairOff, [&](const Fault& fault, std::size_t) {
        longest_pair_off_ = std::max(longest_pair_off_, static_cast<std::size_t>(fault.values[0]));
    });
    schedule_.for_all(FaultKind::kVibration, [&](const Fault& fault, std::size_t i) {
        if (word_of<VibrationShown>(fault, 3) == VibrationShown::kImages) {
            angles_.try_emplace(i, fault, i);
        }
    });
    if (!angles_.empty()) {
        turns_.emplace_back(rig.left, rig.T_B_C0.q);
        turns_.emplace_back(rig.right, rig.T_B_C1.q);
    }
}

template <class Apply>
void FrameFaults::for_images(FaultKind kind, std::size_t camera_value, OwnedFrame& frame, std::uint64_t number,
                             Apply apply) {
    schedule_.for_active(kind, frame.log_stamp, [&](const Fault& fault, std::size_t) {
        for (const bool is_right : {false, true}) {
            if (is_of(word_of<FaultCamera>(fault, camera_value), is_right)) {
                apply(fault, is_right ? frame.right : frame.left, hash64(1, number, is_right ? 1 : 0));
            }
        }
        return true;
    });
}

/// The sum over all vibrations, which are too small for their order to matter.
Eigen::Vector3d FrameFaults::turn_at(Timestamp log_stamp) {
    const Duration t = schedule_.since_begin(log_stamp);
    Eigen::Vector3d theta_B = Eigen::Vector3d::Zero();
    for (auto& [fault, angle] : angles_) {
        if (schedule_.faults().at(fault).is_active_or_before(t)) {
            theta_B += angle.at(t);
        }
    }
    return theta_B;
}

void FrameFaults::shake(OwnedFrame& frame) {
    bool is_shaken = false;
    schedule_.for_active(FaultKind::kVibration, frame.log_stamp, [&](const Fault&, std::size_t i) {
        const bool is_shown = angles_.contains(i);
        is_shaken = is_shaken || is_shown;
        return is_shown;
    });
    if (is_shaken) {
        const Eigen::Vector3d theta_B = turn_at(frame.log_stamp);
        turns_.front().apply(theta_B, frame.left);
        turns_.back().apply(theta_B, frame.right);
    }
}

void FrameFaults::freeze(OwnedFrame& frame) {
    schedule_.for_all(FaultKind::kFreeze, [&](const Fault& fault, std::size_t i) {
        if (!fault.is_active(schedule_.since_begin(frame.log_stamp))) {
            frozen_.erase(i);
        }
    });
    schedule_.for_active(FaultKind::kFreeze, frame.log_stamp, [&](const Fault& fault, std::size_t i) {
        const auto [place, is_first] = frozen_.try_emplace(i, frame);
        const auto camera = word_of<FaultCamera>(fault, 0);
        if (is_of(camera, false)) {
            frame.left = place->second.left;
            frame.has_left = place->second.has_left;
        }
        if (is_of(camera, true)) {
            frame.right = place->second.right;
            frame.has_right = place->second.has_right;
        }
        return true;
    });
}

void FrameFaults::change_scene(OwnedFrame& frame, std::uint64_t number) {
    schedule_.for_active(FaultKind::kMover, frame.log_stamp, [&](const Fault& fault, std::size_t i) {
        const MovingBoard& board = boards_.try_emplace(i, rig_, fault.values[0]).first->second;
        const double shift_m = fault.values[1] * (schedule_.since_begin(frame.log_stamp) - fault.begin).seconds();
        board.draw(false, shift_m, frame.left);
        board.draw(true, shift_m, frame.right);
        return true;
    });
    for_images(FaultKind::kWall, 0, frame, number,
               [](const Fault&, GreyImage& image, std::uint64_t seed) { whiten(seed, image); });
    for_images(FaultKind::kSmear, 0, frame, number,
               [](const Fault&, GreyImage& image, std::uint64_t) { smear(image); });
}

void FrameFaults::change_light(OwnedFrame& frame, std::uint64_t number) {
    for_images(FaultKind::kExposure, 1, frame, number, [&](const Fault& fault, GreyImage& image, std::uint64_t) {
        const double t_s = (schedule_.since_begin(frame.log_stamp) - fault.begin).seconds();
        expose(std::exp2(fault.values[0] * std::sin(2.0 * std::numbers::pi * t_s / kLightPeriod_s)), image);
    });
    for_images(FaultKind::kDark, 1, frame, number, [](const Fault& fault, GreyImage& image, std::uint64_t seed) {
        expose(fault.values[0], image);
        add_pixel_noise(kDarkNoise, seed, image);
    });
    for_images(FaultKind::kFlash, 1, frame, number,
               [](const Fault& fault, GreyImage& image, std::uint64_t) { expose(fault.values[0], image); });
    for_images(FaultKind::kImageNoise, 1, frame, number, [](const Fault& fault, GreyImage& image, std::uint64_t seed) {
        add_pixel_noise(fault.values[0], seed, image);
    });
    for_images(FaultKind::kBlackout, 0, frame, number,
               [](const Fault&, GreyImage& image, std::uint64_t seed) { black_out(seed, image); });
}

/// Before there are as many frames, no right image arrives.
void FrameFaults::pair_with_earlier(OwnedFrame& frame) {
    if (longest_pair_off_ == 0) {
        return;
    }
    const GreyImage own = frame.right;
    schedule_.for_active(FaultKind::kPairOff, frame.log_stamp, [&](const Fault& fault, std::size_t) {
        const auto back = static_cast<std::size_t>(fault.values[0]);
        const bool is_there = back <= earlier_right_.size();
        frame.right = is_there ? earlier_right_[earlier_right_.size() - back] : GreyImage{};
        frame.has_right = !frame.right.pixels.empty();
        return true;
    });
    earlier_right_.push_back(own);
    if (earlier_right_.size() > longest_pair_off_) {
        earlier_right_.pop_front();
    }
}

void FrameFaults::change(OwnedFrame& frame, std::uint64_t number) {
    shake(frame);
    freeze(frame);
    change_scene(frame, number);
    change_light(frame, number);
    pair_with_earlier(frame);
    if (schedule_.is_active(FaultKind::kSwap, frame.log_stamp)) {
        std::swap(frame.left, frame.right);
        std::swap(frame.has_left, frame.has_right);
    }
    frame.has_left = !schedule_.is_active(FaultKind::kNoLeft, frame.log_stamp) && frame.has_left;
    frame.has_right = !schedule_.is_active(FaultKind::kNoRight, frame.log_stamp) && frame.has_right;
}

}  // namespace facet
