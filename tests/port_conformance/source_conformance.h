// SPDX-License-Identifier: BSD-2-Clause
// What every source must do, whatever device is behind it: one suite, run on each implementation.
#pragma once

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <memory>
#include <vector>

#include "platform/port/camera_source.h"
#include "platform/port/imu_source.h"
#include "platform/port/trigger_source.h"
#include "tests/support/stereo_source.h"

namespace facet::test {

/// What a harness answers when the suite asks its world for something.
enum class Hook {
    kDone,
    kCannot,  ///< this kind of source or world has no such thing: that part of the suite is left out
};

/// A source together with the world behind it. To put a new source under the suite, derive from this and call
/// check_source_conformance in a test. Whatever the world cannot do is said in so many words: nothing is left out by
/// being forgotten.
template <class SourceType, class SampleType>
class SourceHarness {
public:
    using Sample = SampleType;

    virtual ~SourceHarness() = default;
    virtual SourceType& source() = 0;
    /// The device produces this many more good samples.
    virtual void offer(int count) = 0;
    /// The device produces one bad sample. kCannot: it cannot tell bad from good.
    virtual Hook offer_corrupt() = 0;
    /// The device produces one sample that is good but for its stamp, which is an hour ahead. kCannot: the source does
    /// not read its stamps from a clock of the host.
    virtual Hook offer_ahead() = 0;
    /// From now on the device fails. kCannot: it never does.
    virtual Hook break_device() = 0;
    virtual void repair_device() = 0;
    /// The source reopens a device that has given no good sample for two seconds.
    virtual Hook judges_silence() = 0;
    /// No more samples. kCannot: this kind of source never ends.
    virtual Hook end() = 0;
    /// Lets a retry period pass.
    virtual void pass_time() = 0;
    /// Samples that the source may hold back because it waits for the next ones.
    virtual int held_back() const = 0;
};

using ImuHarness = SourceHarness<ImuSource, ImuSample>;
using TriggerHarness = SourceHarness<TriggerSource, TriggerEdge>;
using CameraHarness = SourceHarness<CameraSource, CameraFrame>;
using StereoHarness = SourceHarness<StereoSource, StereoFrame>;

inline bool is_sane(const ImuSample& s) { return s.w_B.allFinite() && s.a_B.allFinite(); }
inline bool is_sane(const TriggerEdge&) { return true; }
inline bool is_sane(const CameraFrame& f) { return !f.image.empty() && f.slot.held(); }
inline bool is_sane(const StereoFrame&) { return true; }

inline constexpr Timestamp kUntouched{-12345};

/// Everything the source gives without waiting.
struct Drained {
    std::vector<Timestamp> stamps;
    int corrupt = 0;
    int failures = 0;
    Status last = Status::kNotReady;
};

template <class Harness>
Drained drain(Harness& harness, int limit = 1000) {
    Drained result;
    for (int i = 0; i < limit; ++i) {
        typename Harness::Sample sample;
        sample.stamp = kUntouched;
        result.last = harness.source().next(Duration{}, sample);
        if (result.last == Status::kOk) {
            CHECK(is_sane(sample));
            result.stamps.push_back(sample.stamp);
            continue;
        }
        CHECK(sample.stamp == kUntouched);
        result.corrupt += result.last == Status::kCorrupt ? 1 : 0;
        result.failures += result.last == Status::kIo ? 1 : 0;
        if (result.last != Status::kCorrupt) {
            break;
        }
    }
    return result;
}

inline void check_increasing(const std::vector<Timestamp>& stamps, Timestamp& last, bool& any) {
    for (const Timestamp stamp : stamps) {
        CHECK((!any || stamp > last));
        last = stamp;
        any = true;
    }
}

template <class Harness>
void check_life_cycle(Harness& harness) {
    CHECK(drain(harness).last == Status::kNotReady);  // not started
    CHECK(harness.source().counters().delivered == 0);
    REQUIRE(harness.source().start() == Status::kOk);
    CHECK(harness.source().start() == Status::kOk);
    CHECK(harness.source().problem().empty());
    CHECK(drain(harness).last == Status::kNotReady);  // nothing there yet

    Timestamp last;
    bool any = false;
    harness.offer(10);
    const Drained first = drain(harness);
    CHECK(static_cast<int>(first.stamps.size()) >= 10 - harness.held_back());
    CHECK(first.stamps.size() <= 10);
    check_increasing(first.stamps, last, any);
    CHECK(harness.source().counters().delivered == first.stamps.size());

    harness.source().stop();
    harness.source().stop();
    CHECK(drain(harness).last == Status::kNotReady);
    REQUIRE(harness.source().start() == Status::kOk);
    harness.offer(10);
    const Drained second = drain(harness);
    CHECK(static_cast<int>(second.stamps.size()) >= 10 - harness.held_back());
    check_increasing(second.stamps, last, any);
    CHECK(harness.source().counters().delivered == first.stamps.size() + second.stamps.size());
    CHECK(harness.source().counters().corrupt == 0);
    CHECK(harness.source().counters().errors == 0);
}

template <class Harness>
void check_corrupt_sample(Harness& harness) {
    REQUIRE(harness.source().start() == Status::kOk);
    harness.offer(5);
    Drained all = drain(harness);
    if (harness.offer_corrupt() == Hook::kCannot) {
        return;
    }
    harness.offer(5);
    const Drained rest = drain(harness);
    CHECK(rest.corrupt == 1);
    CHECK(harness.source().counters().corrupt == 1);
    CHECK(static_cast<int>(all.stamps.size() + rest.stamps.size()) >= 10 - 2 * harness.held_back());
    all.stamps.insert(all.stamps.end(), rest.stamps.begin(), rest.stamps.end());
    Timestamp last;
    bool any = false;
    check_increasing(all.stamps, last, any);
}

template <class Harness>
void check_failure_and_recovery(Harness& harness) {
    REQUIRE(harness.source().start() == Status::kOk);
    harness.offer(5);
    Timestamp last;
    bool any = false;
    check_increasing(drain(harness).stamps, last, any);
    if (harness.break_device() == Hook::kCannot) {
        return;
    }
    bool failed = false;
    for (int i = 0; i < 20 && !failed; ++i) {
        const Drained broken = drain(harness);
        failed = broken.failures > 0;
        CHECK(broken.stamps.size() <= 5);
        harness.pass_time();
    }
    REQUIRE(failed);
    CHECK_FALSE(harness.source().problem().empty());
    CHECK(harness.source().counters().errors >= 1);
    CHECK(harness.source().counters().recoveries == 0);

    harness.repair_device();
    std::size_t delivered = 0;
    for (int i = 0; i < 20; ++i) {
        harness.pass_time();
        harness.offer(5);
        const Drained after = drain(harness);
        check_increasing(after.stamps, last, any);
        delivered += after.stamps.size();
    }
    CHECK(delivered >= 50);
    CHECK(harness.source().counters().recoveries == 1);
}

/// One stamp of the future must not keep out the samples after it.
template <class Harness>
void check_stamp_ahead(Harness& harness) {
    REQUIRE(harness.source().start() == Status::kOk);
    harness.offer(5);
    Timestamp last;
    bool any = false;
    check_increasing(drain(harness).stamps, last, any);
    if (harness.offer_ahead() == Hook::kCannot) {
        return;
    }
    const std::vector<Timestamp> ahead = drain(harness).stamps;
    check_increasing(ahead, last, any);
    CHECK(static_cast<int>(ahead.size()) <= harness.held_back());  // it is not delivered
    harness.offer(10);
    const std::vector<Timestamp> after = drain(harness).stamps;
    CHECK(static_cast<int>(after.size()) >= 10 - 2 * harness.held_back());
    check_increasing(after, last, any);
}

/// A device that gives nothing is reported and reopened; so is one whose samples are all bad.
template <class Harness>
void check_silence(Harness& harness, bool with_bad_samples) {
    CAPTURE(with_bad_samples);
    REQUIRE(harness.source().start() == Status::kOk);
    harness.offer(5);
    (void)drain(harness);
    if (harness.judges_silence() == Hook::kCannot) {
        return;
    }
    for (int i = 0; i < 50; ++i) {
        if (with_bad_samples && harness.offer_corrupt() == Hook::kCannot) {
            return;
        }
        const Drained bad = drain(harness);
        CHECK(static_cast<int>(bad.stamps.size()) <= harness.held_back());
        harness.pass_time();
    }
    CHECK(harness.source().counters().errors == 1);
    CHECK(harness.source().counters().recoveries == 0);
    CHECK_FALSE(harness.source().problem().empty());
    for (int i = 0; i < 5; ++i) {
        harness.pass_time();
        harness.offer(5);
        (void)drain(harness);
    }
    CHECK(harness.source().counters().recoveries == 1);
}

template <class Harness>
void check_end(Harness& harness) {
    REQUIRE(harness.source().start() == Status::kOk);
    harness.offer(3);
    if (harness.end() == Hook::kCannot) {
        return;
    }
    const Drained all = drain(harness);
    CHECK(all.last == Status::kEndOfStream);
    CHECK(drain(harness).last == Status::kEndOfStream);
}

/// Runs the whole suite. @param make  gives a fresh harness, not started
template <class Harness>
void check_source_conformance(const std::function<std::unique_ptr<Harness>()>& make) {
    check_life_cycle(*make());
    check_corrupt_sample(*make());
    check_failure_and_recovery(*make());
    check_stamp_ahead(*make());
    check_silence(*make(), false);
    check_silence(*make(), true);
    check_end(*make());
}

}  // namespace facet::test
