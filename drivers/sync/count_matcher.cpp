// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/sync/count_matcher.h"

#include <cmath>
#include <cstdlib>

namespace facet {
namespace {

/// A missing event is interpolated if the mean spacing there deviates from the period by less than this fraction.
constexpr double kUneven = 0.2;

/// a - b on the circle of 32-bit counts.
std::int32_t count_difference(std::uint32_t a, std::uint32_t b) { return static_cast<std::int32_t>(a - b); }

}  // namespace

void CountMatcher::add_event(const SyncEvent& event) {
    if (!events_.empty() &&
        (event.stamp <= events_.back().stamp || count_difference(event.sequence, events_.back().sequence) <= 0)) {
        return;
    }
    events_.push(event);
}

CountMatcher::Search CountMatcher::nearest(Timestamp target, SyncEvent& event) const {
    const std::int64_t tolerance_ns = options_.period.ns * 2 / 5;
    std::int64_t best_ns = tolerance_ns + 1;
    for (std::size_t i = 0; i < events_.size(); ++i) {
        const std::int64_t error_ns = std::abs((events_[i].stamp - target).ns);
        if (error_ns < best_ns) {
            best_ns = error_ns;
            event = events_[i];
        }
    }
    if (best_ns <= tolerance_ns) {
        return Search::kFound;
    }
    return events_.empty() || events_.back().stamp < target ? Search::kTooEarly : Search::kNone;
}

CountMatcher::Search CountMatcher::by_count(std::uint32_t sequence, Match& result) const {
    if (events_.empty() || count_difference(sequence, events_.back().sequence) > 0) {
        return Search::kTooEarly;
    }
    for (std::size_t i = events_.size(); i-- > 0;) {
        const SyncEvent& at_or_before = events_[i];
        const std::int32_t beyond = count_difference(sequence, at_or_before.sequence);
        if (beyond < 0) {
            continue;
        }
        result = {at_or_before, false};
        if (beyond > 0) {
            const SyncEvent& after = events_[i + 1];
            const auto steps = static_cast<double>(count_difference(after.sequence, at_or_before.sequence));
            const double span_ns = static_cast<double>((after.stamp - at_or_before.stamp).ns);
            // An uncounted event is missing there too.
            if (std::abs(span_ns / steps / static_cast<double>(options_.period.ns) - 1.0) > kUneven) {
                return Search::kNone;
            }
            const double part = static_cast<double>(beyond) / steps;
            result = {{sequence, at_or_before.stamp + Duration{std::llround(part * span_ns)}}, true};
        }
        return Search::kFound;
    }
    return Search::kNone;
}

/// Events a period apart leave no doubt within half a period; one too many between them may come closer.
bool CountMatcher::is_nearest(const Match& match, Timestamp target) const {
    SyncEvent event;
    return match.interpolated || nearest(target, event) != Search::kFound || event.sequence == match.event.sequence;
}

CountMatcher::Outcome CountMatcher::vote(const SyncEvent& frame, Timestamp target, Match& result) {
    SyncEvent event;
    const Search found = nearest(target, event);
    if (found == Search::kTooEarly) {
        return Outcome::kWait;
    }
    if (found == Search::kNone) {
        votes_ = 0;
        return Outcome::kDoubtful;
    }
    const std::uint32_t candidate = event.sequence - frame.sequence;
    votes_ = votes_ > 0 && candidate == candidate_ ? votes_ + 1 : 1;
    candidate_ = candidate;
    if (votes_ < options_.votes) {
        return Outcome::kDoubtful;
    }
    corrections_ += offset_ && *offset_ != candidate ? 1 : 0;
    offset_ = candidate;
    votes_ = 0;
    result = {event, false};
    return Outcome::kMatched;
}

CountMatcher::Outcome CountMatcher::match(const SyncEvent& frame, Match& result) {
    const Timestamp target = frame.stamp - options_.delay;
    if (!options_.use_sequence) {
        SyncEvent event;
        const Search found = nearest(target, event);
        if (found != Search::kFound) {
            return found == Search::kTooEarly ? Outcome::kWait : Outcome::kDoubtful;
        }
        result = {event, false};
        return Outcome::kMatched;
    }
    if (!offset_) {
        return vote(frame, target, result);
    }
    const std::int64_t half_ns = options_.period.ns / 2;
    Match match;
    const Search found = by_count(frame.sequence + *offset_, match);
    if (found == Search::kFound && std::abs((match.event.stamp - target).ns) <= half_ns && is_nearest(match, target)) {
        votes_ = 0;
        result = match;
        return Outcome::kMatched;
    }
    // By count the event is still to come; by time it must not be overdue.
    if (found == Search::kTooEarly && (events_.empty() || events_.back().stamp - target <= Duration{half_ns})) {
        return Outcome::kWait;
    }
    return vote(frame, target, result);
}

}  // namespace facet
