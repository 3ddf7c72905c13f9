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
    bool use_sequence = true;                        ///< false: the frames' count is no good, pair by time alone
    int votes = 5;  ///< frames in a row that must agree before an assignment is believed
};

/// A frame k belongs to event k + n with a constant n, as long as both count what they lose. n is found by time: votes
/// frames in a row that lie nearest to the events k + n, within 0.4 periods. From then on count decides, and time checks:
/// a frame more than half a period from its event is in doubt and not assigned; when votes doubtful frames agree on another
/// n, that one is taken and counted as a correction. So a stale frame in a camera's buffer, or an edge that vanished
/// without a trace, costs `votes` frames and no wrong stamp. Thread-bound. No heap.
class CountMatcher {
public:
    /// Events remembered: more than frames can lag behind.
    static constexpr std::size_t kEvents = 64;

    enum class Outcome : std::uint8_t {
        kMatched,
        kWait,     ///< the event may still come: ask again for the same frame
        kDoubtful  ///< not assigned: not believed yet, or count and time disagree
    };
    struct Match {
        SyncEvent event;
        bool interpolated = false;  ///< the event itself is missing; its stamp is from its neighbours
    };

    explicit CountMatcher(const CountMatcherOptions& options = {}) : options_(options) {}

    /// Events in order; others are ignored.
    void add_event(const SyncEvent& event);
    /// Frames in order, each until it gets something else than kWait.
    Outcome match(const SyncEvent& frame, Match& result);

    /// Times that a believed assignment was replaced.
    std::uint32_t corrections() const { return corrections_; }

private:
    enum class Search : std::uint8_t { kFound, kTooEarly, kNone };

    Search nearest(Timestamp target, SyncEvent& event) const;
    Search by_count(std::uint32_t sequence, Match& result) const;
    Outcome vote(const SyncEvent& frame, Timestamp target, Match& result);

    CountMatcherOptions options_;
    RingBuffer<SyncEvent, kEvents> events_;
    std::optional<std::uint32_t> offset_;  ///< event's sequence - frame's sequence
    std::uint32_t candidate_ = 0;
    int votes_ = 0;
    std::uint32_t corrections_ = 0;
};

}  // namespace facet
