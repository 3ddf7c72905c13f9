// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/sync/synchroniser.h"

#include <cmath>
#include <cstdlib>
#include <utility>

namespace facet {
namespace {

bool is_far(Timestamp a, Timestamp b, Duration limit) { return a - b > limit || b - a > limit; }

/// Whether event a comes after event b, on the circle of counts.
bool is_after(std::uint32_t a, std::uint32_t b) { return static_cast<std::int32_t>(a - b) > 0; }
}  // namespace

const char* to_string(SyncFault fault) {
    switch (fault) {
        case SyncFault::kEpochMismatch: return "clocks have different epochs";
        case SyncFault::kDuplicate: return "duplicate";
        case SyncFault::kOutOfOrder: return "out of order";
        case SyncFault::kGap: return "gap";
        case SyncFault::kMissingLeft: return "left image missing";
        case SyncFault::kMissingRight: return "right image missing";
        case SyncFault::kEdgeInterpolated: return "edge lost, interpolated";
        case SyncFault::kDoubtful: return "count and time disagree";
        case SyncFault::kPairingCorrected: return "pairing corrected";
        case SyncFault::kTriggerSilent: return "no trigger edges";
        case SyncFault::kUnsynchronised: return "cameras expose at different times";
        case SyncFault::kUncovered: return "no inertial samples";
        case SyncFault::kOrderDoubtful: return "the first frame does not follow the first edge";
        case SyncFault::kLargeOffset: return "images about half a period off: edges and frames may be paired wrongly";
        case SyncFault::kCount: break;
    }
    return "unknown";
}

Synchroniser::Synchroniser(const SynchroniserOptions& options) : options_(options) {
    // Without a trigger, the right camera is matched to the left camera's frames.
    const Duration right_reference = options.has_trigger ? Duration{} : options.left_delay;
    stream(SyncCamera::kLeft).matcher =
        CountMatcher({options.period, options.left_delay, options.use_sequence, options.votes});
    stream(SyncCamera::kRight).matcher =
        CountMatcher({options.period, options.right_delay - right_reference, options.use_sequence, options.votes});
}

void Synchroniser::report(SyncFault fault, SyncCamera camera, Timestamp stamp, std::int64_t value) {
    ++counts_[static_cast<std::size_t>(fault)];
    bool& standing = standing_[static_cast<std::size_t>(fault)][static_cast<std::size_t>(camera)];
    if (!standing) {
        reports_.push({fault, camera, stamp, value});
    }
    standing = true;
}

void Synchroniser::clear(SyncFault fault, SyncCamera camera) {
    standing_[static_cast<std::size_t>(fault)][static_cast<std::size_t>(camera)] = false;
}

/// Moved out, not only popped: a ring buffer keeps a popped value, and with it the slot, until its cell is used again.
CameraFrame Synchroniser::take_front(Stream& stream) {
    CameraFrame frame = std::move(stream.pending[0].frame);
    stream.pending.pop_front();
    return frame;
}

void Synchroniser::add_imu(Timestamp stamp) {
    if (!any_imu_ || stamp > newest_imu_) {
        newest_imu_ = stamp;
        any_imu_ = true;
    }
}

/// Edges before this one that left no trace: its stamp lies on the grid of the pulses, further on than its count. Off
/// that grid, or after so long that the cameras' stamps are compared anew, nothing is known.
std::uint32_t Synchroniser::unnoticed_before(const TriggerEdge& edge) const {
    constexpr double kOnGrid = 0.2;  // periods
    if (edge.numbered || !any_edge_) {
        return 0;
    }
    const double periods = (edge.stamp - last_edge_.stamp).seconds() / options_.period.seconds();
    const double whole = std::round(periods);
    const auto arrived = static_cast<double>(edge.sequence + edge_base_ - last_edge_.sequence);
    const bool is_lost = whole > arrived && whole < static_cast<double>(CountMatcher::kEvents);
    return is_lost && std::abs(periods - whole) < kOnGrid ? static_cast<std::uint32_t>(whole - arrived) : 0;
}

Status Synchroniser::add_edge(TriggerEdge edge) {
    if (any_imu_ && is_far(edge.stamp, newest_imu_, options_.epoch_limit)) {
        report(SyncFault::kEpochMismatch, SyncCamera::kNone, edge.stamp, (edge.stamp - newest_imu_).ns);
        return Status::kInvalidArgument;
    }
    clear(SyncFault::kEpochMismatch, SyncCamera::kNone);
    if (any_edge_ && edge.stamp <= last_edge_.stamp) {
        report(edge.stamp == last_edge_.stamp ? SyncFault::kDuplicate : SyncFault::kOutOfOrder, SyncCamera::kNone,
               edge.stamp);
        return Status::kOutOfOrder;
    }
    clear(SyncFault::kDuplicate, SyncCamera::kNone);
    clear(SyncFault::kOutOfOrder, SyncCamera::kNone);
    edge_base_ += unnoticed_before(edge);
    edge.sequence += edge_base_;
    if (by_stamps_) {
        // The count goes on where stamps have brought it: a line that was requested anew does not know of the gap.
        const std::uint32_t carried = count_at(last_by_stamp_, edge.stamp + options_.trigger_delay);
        edge_base_ += carried - edge.sequence;
        edge.sequence = carried;
        by_stamps_ = false;
    }
    if (any_edge_ && edge.sequence - last_edge_.sequence > 1) {
        report(SyncFault::kGap, SyncCamera::kNone, edge.stamp,
               static_cast<std::int64_t>(edge.sequence - last_edge_.sequence) - 1);
    } else {
        clear(SyncFault::kGap, SyncCamera::kNone);
    }
    clear(SyncFault::kTriggerSilent, SyncCamera::kNone);
    first_edge_ = any_edge_ ? first_edge_ : SyncEvent{edge.sequence, edge.stamp + options_.trigger_delay};
    any_edge_ = true;
    last_edge_ = edge;
    for (const SyncCamera camera : {SyncCamera::kLeft, SyncCamera::kRight}) {
        stream(camera).matcher.add_event({edge.sequence, edge.stamp + options_.trigger_delay});
    }
    return Status::kOk;
}

Status Synchroniser::check(SyncCamera camera, const CameraFrame& frame) {
    Stream& s = stream(camera);
    if (any_imu_ && is_far(frame.stamp, newest_imu_, options_.epoch_limit)) {
        report(SyncFault::kEpochMismatch, camera, frame.stamp, (frame.stamp - newest_imu_).ns);
        return Status::kInvalidArgument;
    }
    clear(SyncFault::kEpochMismatch, camera);
    if (s.any && frame.stamp <= s.last.stamp) {
        report(frame.stamp == s.last.stamp ? SyncFault::kDuplicate : SyncFault::kOutOfOrder, camera, frame.stamp);
        return Status::kOutOfOrder;
    }
    if (s.any && options_.use_sequence && frame.sequence == s.last.sequence) {
        report(SyncFault::kDuplicate, camera, frame.stamp);
        return Status::kOutOfOrder;
    }
    clear(SyncFault::kDuplicate, camera);
    clear(SyncFault::kOutOfOrder, camera);
    const double periods = s.any ? (frame.stamp - s.last.stamp).seconds() / options_.period.seconds() : 1.0;
    const std::int64_t missing = options_.use_sequence && s.any
                                     ? static_cast<std::int32_t>(frame.sequence - s.last.sequence) - 1
                                     : std::llround(periods) - 1;
    if (missing > 0) {
        report(SyncFault::kGap, camera, frame.stamp, missing);
    } else {
        clear(SyncFault::kGap, camera);
    }
    return Status::kOk;
}

/// A count that does not rise although time has passed has restarted: the offset follows from the time.
std::uint32_t Synchroniser::base_for(const Stream& s, const CameraFrame& frame) const {
    const Duration passed = frame.stamp - s.last.stamp;
    if (!s.any || is_after(frame.sequence + s.base, s.last.sequence) || passed.ns <= options_.period.ns / 2) {
        return s.base;
    }
    const std::int64_t periods = (passed.ns + options_.period.ns / 2) / options_.period.ns;
    return s.last.sequence + static_cast<std::uint32_t>(periods) - frame.sequence;
}

Status Synchroniser::add(SyncCamera camera, CameraFrame frame) {
    Stream& s = stream(camera);
    const std::uint32_t base = base_for(s, frame);
    frame.sequence += base;
    FACET_TRY(check(camera, frame));
    const SyncEvent added{frame.sequence, frame.stamp};
    s.any = true;
    s.base = base;
    s.last = added;
    if (s.pending.full()) {
        // It waits for an edge, for the left image, or for inertial samples; the report says which.
        const Pending& oldest = s.pending.front();
        const Timestamp needed = oldest.assigned ? oldest.event.stamp : oldest.frame.stamp;
        const bool lonely = camera == SyncCamera::kRight && any_imu_ && newest_imu_ >= needed;
        if (oldest.assigned || !options_.has_trigger) {
            report(lonely ? SyncFault::kMissingLeft : SyncFault::kUncovered, lonely ? SyncCamera::kLeft : camera,
                   oldest.frame.stamp);
        }
        (void)take_front(s);
    }
    const bool is_reference = !options_.has_trigger && camera == SyncCamera::kLeft;
    s.pending.push({std::move(frame), {}, false});
    if (is_reference) {
        Pending& newest = s.pending[s.pending.size() - 1];
        newest.event = {added.sequence, added.stamp - options_.left_delay};
        newest.assigned = true;
        stream(SyncCamera::kRight).matcher.add_event(added);
    }
    if (!any_frame_) {
        any_frame_ = true;
        first_frame_ = added.stamp;
    }
    // The first frame's own edge would have come before it.
    const Timestamp since = any_edge_ ? last_edge_.stamp : first_frame_ - Duration{options_.period.ns / 2};
    const bool silent = options_.has_trigger && added.stamp - since > options_.trigger_silence;
    if (silent) {
        report(SyncFault::kTriggerSilent, SyncCamera::kNone, added.stamp, (added.stamp - since).ns);
        if (!by_stamps_) {
            by_stamps_ = true;
            last_by_stamp_ = any_edge_ ? SyncEvent{last_edge_.sequence, last_edge_.stamp + options_.trigger_delay}
                                       : SyncEvent{0, added.stamp};
        }
    }
    return Status::kOk;
}

void Synchroniser::assign(SyncCamera camera) {
    Stream& s = stream(camera);
    for (std::size_t i = 0; i < s.pending.size();) {
        Pending& p = s.pending[i];
        if (p.assigned) {
            ++i;
            continue;
        }
        if (by_stamps_) {
            assign_by_stamp(camera, p);
            ++i;
            continue;
        }
        if (camera == SyncCamera::kRight && !options_.has_trigger && is_silent(SyncCamera::kLeft)) {
            assign_without_left(p);
            ++i;
            continue;
        }
        CountMatcher::Match match;
        // Events are starts of exposure; a frame's stamp is the midpoint of its exposure.
        const Duration half = options_.has_trigger ? Duration{p.frame.exposure.ns / 2} : Duration{};
        assign_by_order(camera, {p.frame.sequence, p.frame.stamp - half});
        const CountMatcher::Outcome outcome = s.matcher.match({p.frame.sequence, p.frame.stamp - half}, match);
        if (outcome == CountMatcher::Outcome::kWait) {
            return;  // frames are matched in order
        }
        if (s.matcher.corrections() != s.corrections) {
            report(SyncFault::kPairingCorrected, camera, p.frame.stamp, s.matcher.corrections() - s.corrections);
            clear(SyncFault::kPairingCorrected, camera);
            s.corrections = s.matcher.corrections();
        }
        if (outcome == CountMatcher::Outcome::kDoubtful) {
            // This is the first unassigned frame: it is dropped, the assigned ones before it stay.
            report(SyncFault::kDoubtful, camera, p.frame.stamp);
            p.frame = {};
            for (std::size_t k = i; k > 0; --k) {
                s.pending[k] = std::move(s.pending[k - 1]);
            }
            s.pending.pop_front();
            continue;
        }
        clear(SyncFault::kDoubtful, camera);
        if (match.interpolated) {
            report(SyncFault::kEdgeInterpolated, camera, match.event.stamp);
        } else {
            clear(SyncFault::kEdgeInterpolated, camera);
        }
        p.event = {match.event.sequence, match.event.stamp + half};
        p.assigned = true;
        follow_lag(s, p);
        ++i;
    }
}

bool Synchroniser::is_silent(SyncCamera camera) const {
    const Stream& s = stream(camera);
    return any_imu_ && any_frame_ && newest_imu_ - (s.any ? s.last.stamp : first_frame_) > options_.silence;
}

/// Time is measured by inertial samples, which arrive whatever the cameras do.
bool Synchroniser::is_given_up(SyncCamera camera, Timestamp event) const {
    const bool is_there = camera == SyncCamera::kLeft || options_.has_right;
    return !is_there || newest_imu_ - event > options_.pair_wait || is_silent(camera);
}

Synchroniser::Turn Synchroniser::turn() const {
    const auto front = [this](SyncCamera camera) -> const Pending* {
        const Stream& s = stream(camera);
        return s.pending.empty() || !s.pending.front().assigned ? nullptr : &s.pending.front();
    };
    const Pending* left = front(SyncCamera::kLeft);
    const Pending* right = front(SyncCamera::kRight);
    if (left != nullptr && right != nullptr) {  // the later one's camera is already past the earlier one
        const std::uint32_t l = left->event.sequence;
        const std::uint32_t r = right->event.sequence;
        return l == r ? Turn::kBoth : is_after(l, r) ? Turn::kRight : Turn::kLeft;
    }
    if (left != nullptr && is_given_up(SyncCamera::kRight, left->event.stamp)) {
        return Turn::kLeft;
    }
    return right != nullptr && is_given_up(SyncCamera::kLeft, right->event.stamp) ? Turn::kRight : Turn::kNobodys;
}

void Synchroniser::deliver(Turn turn, SyncedFrame& frame) {
    frame.left = {};
    frame.right = {};
    if (turn == Turn::kBoth &&
        !is_pair(stream(SyncCamera::kLeft).pending.front(), stream(SyncCamera::kRight).pending.front())) {
        frame.left = take_front(stream(SyncCamera::kLeft));
        (void)take_front(stream(SyncCamera::kRight));
        return;
    }
    if (turn != Turn::kRight) {
        frame.left = take_front(stream(SyncCamera::kLeft));
        clear(SyncFault::kMissingLeft, SyncCamera::kLeft);
    } else {
        report(SyncFault::kMissingLeft, SyncCamera::kLeft, frame.stamp);
    }
    if (turn != Turn::kLeft) {
        frame.right = take_front(stream(SyncCamera::kRight));
        clear(SyncFault::kMissingRight, SyncCamera::kRight);
    } else if (options_.has_right) {
        report(SyncFault::kMissingRight, SyncCamera::kRight, frame.stamp);
    }
}

Status Synchroniser::pop(SyncedFrame& frame) {
    assign(SyncCamera::kLeft);
    assign(SyncCamera::kRight);
    for (Turn next = turn(); any_imu_ && next != Turn::kNobodys; next = turn()) {
        const SyncCamera camera = next == Turn::kRight ? SyncCamera::kRight : SyncCamera::kLeft;
        const Pending& first = stream(camera).pending.front();
        const SyncEvent event = first.event;
        if (newest_imu_ < event.stamp) {
            return Status::kNotReady;
        }
        clear(SyncFault::kUncovered, camera);
        if (any_given_ && event.stamp <= last_given_) {
            report(SyncFault::kOutOfOrder, camera, event.stamp);
            (void)take_front(stream(camera));
            continue;
        }
        frame.stamp = event.stamp;
        frame.event = event.sequence;
        frame.is_by_stamps = first.by_stamp;
        deliver(next, frame);
        any_given_ = true;
        last_given_ = frame.stamp;
        return Status::kOk;
    }
    return Status::kNotReady;
}

Status Synchroniser::pop_report(SyncReport& report) {
    if (reports_.empty()) {
        return Status::kNotReady;
    }
    report = reports_.front();
    reports_.pop_front();
    return Status::kOk;
}

}  // namespace facet
