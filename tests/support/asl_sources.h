// SPDX-License-Identifier: BSD-2-Clause
// A recorded log in the place of sensors.
#pragma once

#include <optional>
#include <string>

#include "drivers/replay_asl/asl_dataset.h"
#include "platform/port/imu_source.h"
#include "tests/support/stereo_source.h"

namespace facet {

/// How the time of a log becomes the time of its playback: the log's instant `log_begin` is now at `host_begin`.
struct AslPace {
    Timestamp log_begin;
    Timestamp host_begin;
    bool as_fast_as_asked = false;  ///< samples are there at once; else when their time has come
    bool keep_stamps = true;        ///< else stamps are moved by host_begin - log_begin, as if measured now
};

struct AslSourceOptions {
    std::string folder;
    AslOptions log;
    AslPace pace;
};

/// What both sources share: a log of its own that is read forward, and the waiting. The position outlives stop(). Bad
/// rows and images are kCorrupt, once for each; warnings go to the sink of the constructor. Never fails once started,
/// but ends. Thread-bound. Heap.
class AslPlayback {
public:
    /// Borrowed: clock, which must outlive this.
    AslPlayback(Clock& clock, AslSourceOptions options, AslWarningSink sink);

    Status start();
    void stop() { started_ = false; }
    const SourceCounters& counters() const { return counters_; }
    std::string_view problem() const { return problem_; }

    /// Next event of the kind wanted, others are passed over. @return as Source::next
    Status next(AslDataset::Event wanted, Duration timeout, ImuSample& sample, StereoFrame& frame);

private:
    Status wait_for(Timestamp stamp, Duration timeout);

    Clock& clock_;
    AslSourceOptions options_;
    AslWarningSink sink_;
    AslDataset log_;
    SourceCounters counters_;
    std::string problem_;
    bool opened_ = false;
    bool started_ = false;
    bool ended_ = false;
    std::uint64_t bad_ = 0;         ///< samples found bad while looking for the next one, not reported yet
    std::optional<Timestamp> due_;  ///< of the sample that waits below
    ImuSample sample_;
    StereoFrame frame_;
};

/// The log's stereo pairs; the right view is empty where the log has none.
class AslStereoSource final : public StereoSource {
public:
    AslStereoSource(Clock& clock, AslSourceOptions options, AslWarningSink sink = {})
        : playback_(clock, std::move(options), std::move(sink)) {}

    Status start() override { return playback_.start(); }
    void stop() override { playback_.stop(); }
    Status next(Duration timeout, StereoFrame& frame) override {
        ImuSample unused;
        return playback_.next(AslDataset::Event::kFrame, timeout, unused, frame);
    }
    ClockDomain clock() const override { return ClockDomain::kMonotonic; }
    SourceCounters counters() const override { return playback_.counters(); }
    std::string_view problem() const override { return playback_.problem(); }

private:
    AslPlayback playback_;
};

/// The log's inertial samples. Reads no image.
class AslImuSource final : public ImuSource {
public:
    AslImuSource(Clock& clock, AslSourceOptions options, AslWarningSink sink = {})
        : playback_(clock, without_images(std::move(options)), std::move(sink)) {}

    Status start() override { return playback_.start(); }
    void stop() override { playback_.stop(); }
    Status next(Duration timeout, ImuSample& sample) override {
        StereoFrame unused;
        return playback_.next(AslDataset::Event::kImu, timeout, sample, unused);
    }
    ClockDomain clock() const override { return ClockDomain::kMonotonic; }
    SourceCounters counters() const override { return playback_.counters(); }
    std::string_view problem() const override { return playback_.problem(); }

private:
    static AslSourceOptions without_images(AslSourceOptions options) {
        options.log.decode_images = false;
        return options;
    }

    AslPlayback playback_;
};

}  // namespace facet
