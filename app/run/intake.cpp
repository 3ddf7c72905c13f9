// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/intake.h"

namespace facet {

std::size_t Intake::take_edges() {
    std::size_t taken = 0;
    for (TriggerEdge edge; ok(queues_.edges.pop(edge)); ++taken) {
        if (tap_ != nullptr) {
            tap_->on_edge(edge);
        }
        (void)sync_.add_edge(edge);  // refused ones are counted there
    }
    return taken;
}

void Intake::add_halves(CameraFrame both) {
    CameraFrame left = std::move(both);
    left.image.width /= 2;
    CameraFrame right{left.stamp, left.sequence, left.image, left.slot.share(), left.exposure};
    right.image.data += right.image.width;
    (void)sync_.add_left(std::move(left));  // refused ones are counted there
    (void)sync_.add_right(std::move(right));
}

bool Intake::take_left() {
    CameraFrame frame;
    if (!ok(queues_.left.pop(frame))) {
        return false;
    }
    if (options_.side_by_side) {
        add_halves(std::move(frame));
    } else {
        (void)sync_.add_left(std::move(frame));
    }
    return true;
}

bool Intake::take_right() {
    CameraFrame frame;
    if (!ok(queues_.right.pop(frame))) {
        return false;
    }
    (void)sync_.add_right(std::move(frame));
    return true;
}

void Intake::give(const ImuSample& sample) {
    if (tap_ != nullptr) {
        tap_->on_imu(sample);
    }
    sync_.add_imu(sample.stamp - options_.camera_time_shift);
}

void Intake::show_range(const RangeSample& sample, Timestamp frame) {
    if (tap_ != nullptr) {
        tap_->on_range(sample, frame);
    }
}

bool Intake::pop(SyncedFrame& frame) {
    if (!ok(sync_.pop(frame))) {
        return false;
    }
    if (tap_ != nullptr) {
        tap_->on_pair(frame);
    }
    return true;
}

void Intake::publish(SharedFindings& findings) const {
    for (std::size_t i = 0; i < findings.size(); ++i) {
        findings[i].store(sync_.count(static_cast<SyncFault>(i)), std::memory_order_relaxed);
    }
}

}  // namespace facet
