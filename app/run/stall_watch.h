// SPDX-License-Identifier: BSD-2-Clause
// Whether a thread is still at work: the estimator's, the sinks', or the one that reads the inertial sensor.
#pragma once

#include <atomic>
#include <optional>

#include "platform/port/clock.h"

namespace facet {

/// A thread reports that it is alive, the estimator's and the sinks' whenever they have taken something or waited for
/// something, the inertial sensor's at every sample; whoever asks learns of a silence that no frame explains.
/// Thread-safe, one thread that beats. No heap, no lock.
class StallWatch {
public:
    /// Three times what a keyframe takes on a slow computer; with the pause of whoever asks, 50 ms, a stall is known
    /// after 200 ms.
    static constexpr Duration kPatience = Duration::from_seconds(0.15);

    /// Borrowed: clock. Nothing is a stall before the first beat.
    explicit StallWatch(const Clock& clock) : clock_(clock) {}

    /// On the thread that is watched.
    void beat() { beaten_ns_.store(clock_.now().ns, std::memory_order_relaxed); }

    /// On the thread that is watched: it ends.
    void end() { beaten_ns_.store(kNever, std::memory_order_relaxed); }

    /// After the first beat, until it ends.
    bool is_awaited() const { return beaten_ns_.load(std::memory_order_relaxed) != kNever; }

    /// How long the thread has been silent, if that is longer than kPatience.
    std::optional<Duration> silence() const {
        const std::int64_t beaten_ns = beaten_ns_.load(std::memory_order_relaxed);
        const Duration silence{clock_.now().ns - beaten_ns};
        return beaten_ns != kNever && silence > kPatience ? std::optional(silence) : std::nullopt;
    }

private:
    static constexpr std::int64_t kNever = -1;

    const Clock& clock_;
    std::atomic<std::int64_t> beaten_ns_{kNever};
};

}  // namespace facet
