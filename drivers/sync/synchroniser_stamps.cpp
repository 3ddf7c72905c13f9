// SPDX-License-Identifier: BSD-2-Clause
// What Synchroniser does where there are no edges: it goes by the cameras' own stamps.
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "drivers/sync/synchroniser.h"

namespace facet {
namespace {

/// Means follow slowly: a sixteenth of each new value.
constexpr double kShare = 1.0 / 16.0;

/// Of a period: as in CountMatcher.
constexpr double kOnTime = 0.4;

}  // namespace

/// Frames before the first edge are stale. The first one after it is that edge's if it also lies there in time; if it
/// is later, either the camera has let the first pulses pass or its stamps are late, and time has to decide by votes.
void Synchroniser::assign_by_order(SyncCamera camera, const SyncEvent& frame) {
    Stream& s = stream(camera);
    if (!options_.first_is_first || s.is_ordered || !any_edge_) {
        return;
    }
    const Duration delay = camera == SyncCamera::kLeft ? options_.left_delay : options_.right_delay;
    const double periods = (frame.stamp - delay - first_edge_.stamp).seconds() / options_.period.seconds();
    if (periods < -kOnTime) {
        return;
    }
    s.is_ordered = true;
    if (periods <= kOnTime) {
        s.matcher.accept(first_edge_.sequence - frame.sequence);
    } else {
        report(SyncFault::kOrderDoubtful, camera, frame.stamp, std::llround(periods));
    }
}

void Synchroniser::add_offset(Timestamp stamp, Duration offset, Duration sigma) {
    constexpr double kSure = 3.0;  // standard deviations
    const double size_ns = std::abs(static_cast<double>(offset.ns));
    if (size_ns > kOnTime * static_cast<double>(options_.period.ns) &&
        size_ns > kSure * static_cast<double>(sigma.ns)) {
        report(SyncFault::kLargeOffset, SyncCamera::kNone, stamp, offset.ns);
    } else {
        clear(SyncFault::kLargeOffset, SyncCamera::kNone);
    }
}

/// The count of the event at `stamp`, by the periods since a known one.
std::uint32_t Synchroniser::count_at(const SyncEvent& known, Timestamp stamp) const {
    const std::int64_t periods = std::llround((stamp - known.stamp).seconds() / options_.period.seconds());
    return known.sequence + static_cast<std::uint32_t>(periods);
}

void Synchroniser::follow_lag(Stream& s, const Pending& pending) const {
    if (options_.has_trigger) {
        const auto lag_ns = static_cast<double>((pending.frame.stamp - pending.event.stamp).ns);
        s.lag_ns += (lag_ns - s.lag_ns) * (s.any_lag ? kShare : 1.0);
        s.any_lag = true;
    }
}

/// The trigger is silent: the image's own stamp says when it was exposed, and what number the edge would have had.
void Synchroniser::assign_by_stamp(SyncCamera camera, Pending& pending) {
    const Stream& s = stream(camera);
    const Duration nominal = camera == SyncCamera::kLeft ? options_.left_delay : options_.right_delay;
    const Duration lag = s.any_lag ? Duration{std::llround(s.lag_ns)} : nominal;
    pending.event.stamp = pending.frame.stamp - lag;
    const Timestamp start = pending.event.stamp - Duration{pending.frame.exposure.ns / 2};
    pending.event.sequence = count_at(last_by_stamp_, start);
    pending.assigned = true;
    pending.by_stamp = true;
    if (static_cast<std::int32_t>(pending.event.sequence - last_by_stamp_.sequence) > 0) {
        last_by_stamp_ = {pending.event.sequence, start};
    }
}

/// Whether two images of one event were exposed together, as far as stamps tell. Edges need no such proof.
bool Synchroniser::is_pair(const Pending& left, const Pending& right) {
    if (options_.has_trigger && !by_stamps_) {
        return true;
    }
    const Timestamp right_stamp = options_.has_trigger ? right.event.stamp : right.frame.stamp - options_.right_delay;
    const auto skew_ns = static_cast<double>((right_stamp - left.event.stamp).ns);
    skew_ns_ += (skew_ns - skew_ns_) * std::max(kShare, 1.0 / ++skews_);
    skews_ = std::min(skews_, 1000);
    if (std::abs(skew_ns_) <= static_cast<double>(options_.skew_limit.ns)) {
        clear(SyncFault::kUnsynchronised, SyncCamera::kNone);
        return true;
    }
    report(SyncFault::kUnsynchronised, SyncCamera::kNone, left.event.stamp, std::llround(skew_ns_));
    return false;
}

/// The image is an event of its own, its count the one that the left camera's image would have.
void Synchroniser::assign_without_left(Pending& right) const {
    const Stream& l = stream(SyncCamera::kLeft);
    right.event.stamp = right.frame.stamp - options_.right_delay;
    const Duration passed = right.event.stamp - (l.any ? l.last.stamp - options_.left_delay : first_frame_);
    const std::int64_t periods = std::llround(passed.seconds() / options_.period.seconds());
    right.event.sequence = l.last.sequence + static_cast<std::uint32_t>(periods);
    right.assigned = true;
}

}  // namespace facet
