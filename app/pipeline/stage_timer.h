// SPDX-License-Identifier: BSD-2-Clause
// Times the stages of one frame, by the steady clock and by the processor's.
#pragma once

#include <chrono>

#include "app/output/frame_log.h"
#include "app/support/processor_time.h"

namespace facet {

/// StageObserver that adds up the time of each stage until taken. Thread-bound. No heap.
class StageTimer final : public StageObserver {
public:
    /// Two clocks, read together.
    struct Instant {
        std::chrono::steady_clock::time_point wall;
        double processor_s = 0.0;  ///< of this thread
    };
    static Instant now() { return {std::chrono::steady_clock::now(), thread_processor_s()}; }

    void begin(Stage /*stage*/) override { begin_ = now(); }
    void end(Stage stage) override { add(begin_, timing_.stages[static_cast<std::size_t>(stage)]); }
    void add_total(const Instant& begin) { add(begin, timing_.total); }
    /// The frame's estimate is ready.
    void mark_estimate() { timing_.estimate = timing_.total; }

    /// Times since the last call.
    FrameTiming take() {
        const FrameTiming taken = timing_;
        timing_ = {};
        return taken;
    }

private:
    static void add(const Instant& begin, SpentTime& sum) {
        const Instant end = now();
        sum.wall_ms += std::chrono::duration<double, std::milli>(end.wall - begin.wall).count();
        sum.processor_ms += 1e3 * (end.processor_s - begin.processor_s);
    }

    Instant begin_;
    FrameTiming timing_;
};

}  // namespace facet
