// SPDX-License-Identifier: BSD-2-Clause
// What the stamps of samples and frames show about the clocks, and when frames come.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <optional>

#include "estimator/values/refused_run.h"
#include "platform/base/timestamp.h"

namespace facet {

/// Samples and frames that are refused for their stamps, and the time that passes meanwhile. Thread-bound. No heap.
class ClockWatch {
public:
    void refuse_sample(Timestamp stamp) { refused_samples_.add(stamp); }
    void refuse_frame(Timestamp image) { refused_frames_.add(image); }
    /// A frame has been offered, taken or not. @param stamp  in the IMU's clock
    void offer(Timestamp stamp) { offered_ = stamp; }

    /// The refused samples come from a clock, and frames come from the same one. @param newest  sample that was taken
    bool is_new_clock(Timestamp newest) const {
        return refused_samples_.is_clock() && offered_ && *offered_ >= refused_samples_.clock_begin() &&
               *offered_ <= refused_samples_.newest() && newest - refused_samples_.newest() > kBehind;
    }
    /// Of the newest frame that was offered; only if is_new_clock().
    Timestamp offered() const { return *offered_; }
    /// Time on the new clock since it began, or since an estimate of the old one.
    double time_on_new_clock_s(Timestamp estimate) const {
        return std::max((refused_samples_.newest() - refused_samples_.clock_begin()).seconds(),
                        (*offered_ - estimate).seconds());
    }

    /// A sample has been taken. @return the time that has passed on no clock before it; 0 if it is too short to count
    double take_time_without_samples_s() { return counted(refused_samples_.take_s()); }
    /// A frame is about to be taken; likewise.
    double take_time_without_frames_s() { return counted(refused_frames_.take_s()); }

    /// Time without samples since the window began (s).
    void lose(double time_s) { lost_s_ += time_s; }
    double take_lost_s() {
        const double lost_s = lost_s_;
        lost_s_ = 0.0;
        return lost_s;
    }

    /// A start like the first one: what was refused before no longer counts.
    void forget_refused() {
        refused_samples_ = refused_frames_ = {};
        lost_s_ = 0.0;
    }

private:
    /// A clock that is behind by no more than this catches up soon enough, and what is known until then is worth more.
    static constexpr Duration kBehind = Duration::from_seconds(1.0);

    static double counted(double time_s) { return time_s > RefusedRun::kLeast_s ? time_s : 0.0; }

    RefusedRun refused_samples_;  ///< since the last one that was taken
    RefusedRun refused_frames_;
    std::optional<Timestamp> offered_;
    double lost_s_ = 0.0;
};

/// When frames come. Thread-bound. No heap.
struct FrameTimes {
    /// Between two estimates without frames.
    static constexpr double kCarry_s = 0.1;
    /// Inertial samples younger than this may belong before a frame on its way; it grows if one is later, up to a
    /// second.
    static constexpr Duration kUsualLatency = Duration::from_seconds(0.2);
    static constexpr Duration kLongestLatency = Duration::from_seconds(1.0);
    /// Frames that have not come for this long are missing: five periods of a camera at 10 Hz.
    static constexpr double kMissing_s = 0.5;

    Timestamp last_image;  ///< stamp of the last frame as given
    Timestamp last_frame;  ///< the same in the IMU's clock, as believed then
    Duration latency;      ///< inertial samples this young may belong before a frame that is still to come
    /// Of the body since the last frame that the front-end has taken, where the state was carried on without frames.
    Eigen::Quaterniond q_Bf_B = Eigen::Quaterniond::Identity();

    /// A frame came too late for the state carried on without it: from now on that waits longer.
    /// @param late  of the newest sample, after the frame
    void expect_late(Duration late) {
        latency = std::clamp(late + Duration::from_seconds(kCarry_s), latency, kLongestLatency);
    }
    /// Up to when the state can be carried on without waiting for frames. @param newest  sample
    Timestamp carry_until(Timestamp newest) const { return newest - std::max(latency, kUsualLatency); }
    bool are_missing(Timestamp newest) const { return (newest - last_frame).seconds() > kMissing_s; }
};

}  // namespace facet
