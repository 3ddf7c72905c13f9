// SPDX-License-Identifier: BSD-2-Clause
// Which trigger edge a frame belongs to: by count, checked by time.
#pragma once

#include <cstdint>
#include <optional>

#include "platform/base/ring_buffer.h"
#include "platform/base/timestamp.h"

namespace facet {

/// An event that frames belong to: a trigger edge, or a frame of the other camera.
struct SyncEvent {
    std::uint32_t sequence = 0;
    Timestamp stamp;
};

struct CountMatcherOptions {
    Duration period = Duration::from_seconds(0.05);  ///< nominal, between events
    Duration delay;                                  ///< nominal, from an event's stamp to its frame's
    bool use_sequence = true;                        ///< false: the frames' count is unusable, pair by time alone
    int votes = 5;  ///< consecutive frames that must agree before an assignment is accepted
};

/// Frame k belongs to event k + n with a constant n, as long as both sides count what they lose. n is found by time:
/// `votes` consecutive frames must lie nearest to the events k + n, within 0.4 periods. From then on the count decides
/// and time checks: a frame more than half a period from its event, or nearer to another one (as when a line bounces),
/// is doubtful and not assigned; when `votes` doubtful frames agree on another n, that one is adopted and counted as a
/// correction. Thus a stale frame in a camera's buffer, or an edge lost without a trace, costs `votes` frames but never
/// gives a wrong stamp. Thread-bound. No heap.
class CountMatcher {
public:
    /// Events kept: more than frames can lag behind.
    static constexpr std::size_t kEvents = 64;

    enum class Outcome : std::uint8_t {
        kMatched,
        kWait,     ///< the event may still come: call again with the same frame
        kDoubtful  ///< not assigned: no assignment accepted yet, or count and time disagree
    };
    struct Match {
        SyncEvent event;
        bool interpolated = false;  ///< the event is missing; its stamp is interpolated between its neighbours
    };

    explicit CountMatcher(const CountMatcherOptions& options = {}) : options_(options) {}

    /// Adds events in order; those out of order are ignored.
    void add_event(const SyncEvent& event);
    /// Call with frames in order, and with each one until the outcome is not kWait.
    Outcome match(const SyncEvent& frame, Match& result);

    /// Accepts that frame k belongs to event k + offset, known from elsewhere; time goes on checking.
    void accept(std::uint32_t offset) { offset_ = offset; }

    /// How often an accepted assignment was replaced.
    std::uint32_t corrections() const { return corrections_; }

private:
    enum class Search : std::uint8_t { kFound, kTooEarly, kNone };

    Search nearest(Timestamp target, SyncEvent& event) const;
    Search by_count(std::uint32_t sequence, Match& result) const;
    bool is_nearest(const Match& match, Timestamp target) const;
    Outcome vote(const SyncEvent& frame, Timestamp target, Match& result);

    CountMatcherOptions options_;
    RingBuffer<SyncEvent, kEvents> events_;
    std::optional<std::uint32_t> offset_;  ///< event's sequence - frame's sequence
    std::uint32_t candidate_ = 0;
    int votes_ = 0;
    std::uint32_t corrections_ = 0;
};

}  // namespace facet
