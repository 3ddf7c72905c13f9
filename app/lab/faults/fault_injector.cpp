// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/faults/fault_injector.h"

#include <algorithm>
#include <utility>

#include "app/lab/faults/image_faults.h"

namespace facet {

FaultInjector::FaultInjector(std::vector<Fault> faults, const ImuNoise& noise, const StereoRig& rig, Timestamp begin)
    : schedule_(std::move(faults), begin), inertial_(schedule_, noise), images_(schedule_, rig) {}

/// Whether a fault lets only each N-th sample through, and this is none of them.
bool FaultInjector::is_thinned(FaultKind kind, Timestamp log_stamp, std::uint64_t number) {
    bool lost = false;
    schedule_.for_active(kind, log_stamp, [&](const Fault& fault, std::size_t) {
        const bool is_left_out = number % static_cast<std::uint64_t>(fault.values[0]) != 0;
        lost = lost || is_left_out;
        return is_left_out;
    });
    return lost;
}

bool FaultInjector::is_doubled(FaultKind kind, Timestamp log_stamp, std::uint64_t number) {
    bool twice = false;
    schedule_.for_active(kind, log_stamp, [&](const Fault& fault, std::size_t i) {
        const bool is_drawn = FaultSchedule::draws(fault.kind, i, 1, number).uniform() < fault.values[0];
        twice = twice || is_drawn;
        return is_drawn;
    });
    return twice;
}

void FaultInjector::emit(const ImuSample& sample) {
    out_.emplace_back(sample);
    newest_imu_ = has_imu_ ? std::max(newest_imu_, sample.stamp) : sample.stamp;
    has_imu_ = true;
}

void FaultInjector::deliver(const ImuSample& sample, Timestamp log_stamp) {
    if (schedule_.is_active(FaultKind::kImuOrder, log_stamp) && !overtaken_.has_value()) {
        overtaken_ = sample;
        return;
    }
    emit(sample);
    if (overtaken_.has_value()) {
        emit(*overtaken_);
        overtaken_.reset();
    }
}

void FaultInjector::add(const ImuSample& sample) {
    ++imu_count_;
    if (!schedule_.is_active(FaultKind::kImuGap, sample.stamp) &&
        !is_thinned(FaultKind::kImuThin, sample.stamp, imu_count_)) {
        ImuSample out = sample;
        inertial_.change(out, imu_count_);
        out.stamp = sample.stamp + schedule_.shift(FaultKind::kClockJump, sample.stamp) +
                    schedule_.shift(FaultKind::kImuJump, sample.stamp);
        deliver(out, sample.stamp);
        if (is_doubled(FaultKind::kImuDuplicate, sample.stamp, imu_count_)) {
            deliver(out, sample.stamp);
        }
    }
    release(sample.stamp);
}

bool FaultInjector::is_lost(const OwnedFrame& frame) {
    bool lost = !frame.has_left && !frame.has_right;
    schedule_.for_active(FaultKind::kDropFrames, frame.log_stamp, [&](const Fault& fault, std::size_t i) {
        const auto seed = static_cast<std::uint64_t>(fault.values[1]);
        const bool dropped = FaultSchedule::draws(fault.kind, i, seed, frame_count_).uniform() < fault.values[0];
        lost = lost || dropped;
        return dropped;
    });
    return is_thinned(FaultKind::kFrameThin, frame.log_stamp, frame_count_) || lost;
}

void FaultInjector::deliver(OwnedFrame frame) {
    if (schedule_.is_active(FaultKind::kFrameOrder, frame.log_stamp) && !late_frame_.has_value()) {
        late_frame_ = std::move(frame);
        return;
    }
    waiting_.push_back(std::move(frame));
    if (late_frame_.has_value()) {
        waiting_.push_back(std::move(*late_frame_));
        late_frame_.reset();
    }
}

void FaultInjector::add(const StereoFrame& frame) {
    ++frame_count_;
    OwnedFrame owned;
    owned.log_stamp = frame.stamp;
    owned.output_stamp = frame.stamp + schedule_.shift(FaultKind::kTimeOffset, frame.stamp);
    owned.stamp = owned.output_stamp + schedule_.shift(FaultKind::kClockJump, frame.stamp) +
                  schedule_.shift(FaultKind::kFrameJump, frame.stamp);
    owned.has_left = !frame.left.empty();
    owned.has_right = !frame.right.empty();
    copy_image(frame.left, owned.left);
    copy_image(frame.right, owned.right);
    images_.change(owned, frame_count_);
    if (!is_lost(owned)) {
        if (is_doubled(FaultKind::kFrameDuplicate, frame.stamp, frame_count_)) {
            deliver(owned);
        }
        deliver(std::move(owned));
    }
    release(frame.stamp);
}

void FaultInjector::release(Timestamp log_now) {
    const auto is_due = [&](const OwnedFrame& frame) {
        return (has_imu_ && frame.stamp <= newest_imu_) || log_now - frame.log_stamp > kMaxWait;
    };
    while (!waiting_.empty() && is_due(waiting_.front())) {
        out_.emplace_back(std::move(waiting_.front()));
        waiting_.pop_front();
    }
}

void FaultInjector::finish() {
    if (overtaken_.has_value()) {
        emit(*overtaken_);
        overtaken_.reset();
    }
    if (late_frame_.has_value()) {
        waiting_.push_back(std::move(*late_frame_));
        late_frame_.reset();
    }
    for (OwnedFrame& frame : waiting_) {
        out_.emplace_back(std::move(frame));
    }
    waiting_.clear();
}

}  // namespace facet
