// SPDX-License-Identifier: BSD-2-Clause
// Times the stages of one frame with the steady clock.
#pragma once

#include <chrono>

#include "app/output/frame_log.h"

namespace facet {

/// StageObserver that adds up the time of each stage until taken. Thread-bound. No heap.
class StageTimer final : public StageObserver {
public:
    using Clock = std::chrono::steady_clock;

    void begin(Stage /*stage*/) override { begin_ = Clock::now(); }
    void end(Stage stage) override { timing_.stage_ms[static_cast<std::size_t>(stage)] += ms_since(begin_); }
    void add_total(Clock::time_point begin) { timing_.total_ms += ms_since(begin); }

    /// Times since the last call.
    FrameTiming take() {
        const FrameTiming taken = timing_;
        timing_ = {};
        return taken;
    }

private:
    static double ms_since(Clock::time_point begin) {
        return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
    }

    Clock::time_point begin_;
    FrameTiming timing_;
};

}  // namespace facet
