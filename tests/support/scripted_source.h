// SPDX-License-Identifier: BSD-2-Clause
// Sources that play a list from memory, and a clock that only moves on request, for tests.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "platform/port/clock.h"
#include "platform/port/imu_source.h"
#include "platform/port/trigger_source.h"
#include "tests/support/stereo_source.h"

namespace facet {

/// A clock that stands still; sleeping moves it. Thread-bound.
class ManualClock final : public Clock {
public:
    explicit ManualClock(Timestamp now = {}, Duration realtime_offset = {}) : now_(now), offset_(realtime_offset) {}

    Timestamp now() const override { return now_; }
    ClockPair read_pair() const override { return {now_, now_ + offset_, {}}; }
    void sleep_until(Timestamp until) override { now_ = until > now_ ? until : now_; }
    void advance(Duration span) { now_ = now_ + span; }
    /// A step of the wall clock.
    void set_realtime_offset(Duration offset) { offset_ = offset; }

private:
    Timestamp now_;
    Duration offset_;
};

/// Plays outcomes in order: samples, and failures at the places where they were put. Base is ImuSource, TriggerSource
/// or StereoSource, Sample what it delivers. A sample whose stamp does not increase is discarded, as every source must.
/// An empty list means kNotReady until finish() was called. Heap in the functions that fill the list.
template <class Base, class Sample>
class ScriptedSource final : public Base {
public:
    explicit ScriptedSource(ClockDomain clock = ClockDomain::kMonotonic) : clock_(clock) {}

    void add(const Sample& sample) { script_.push_back({Status::kOk, sample, {}}); }
    /// kCorrupt or kIo at this place of the script. @param problem  words for kIo
    void add_failure(Status failure, std::string problem = {}) {
        script_.push_back({failure, Sample{}, std::move(problem)});
    }
    /// kEndOfStream once the list is empty.
    void finish() { finished_ = true; }

    Status start() override {
        started_ = true;
        return Status::kOk;
    }
    void stop() override { started_ = false; }

    Status next(Duration, Sample& sample) override {
        if (!started_) {
            return Status::kNotReady;
        }
        while (next_ < script_.size()) {
            const Step& step = script_[next_++];
            if (step.outcome == Status::kCorrupt) {
                ++counters_.corrupt;
                return Status::kCorrupt;
            }
            if (step.outcome != Status::kOk) {
                problem_ = step.problem;
                failing_ = true;
                ++counters_.errors;
                return step.outcome;
            }
            if (counters_.delivered > 0 && step.sample.stamp <= last_) {
                ++counters_.discarded;
                continue;
            }
            counters_.recoveries += failing_ ? 1 : 0;
            failing_ = false;
            ++counters_.delivered;
            last_ = step.sample.stamp;
            sample = step.sample;
            return Status::kOk;
        }
        return finished_ ? Status::kEndOfStream : Status::kNotReady;
    }

    ClockDomain clock() const override { return clock_; }
    SourceCounters counters() const override { return counters_; }
    std::string_view problem() const override { return problem_; }

private:
    struct Step {
        Status outcome = Status::kOk;
        Sample sample;
        std::string problem;
    };

    ClockDomain clock_;
    std::vector<Step> script_;
    std::size_t next_ = 0;
    Timestamp last_;
    SourceCounters counters_;
    std::string problem_;
    bool started_ = false;
    bool failing_ = false;
    bool finished_ = false;
};

using ScriptedImu = ScriptedSource<ImuSource, ImuSample>;
using ScriptedTrigger = ScriptedSource<TriggerSource, TriggerEdge>;
using ScriptedStereo = ScriptedSource<StereoSource, StereoFrame>;

}  // namespace facet
