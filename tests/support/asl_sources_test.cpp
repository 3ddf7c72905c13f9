// SPDX-License-Identifier: BSD-2-Clause
#include "tests/support/asl_sources.h"

#include <catch2/catch.hpp>

#include "tests/port_conformance/source_conformance.h"
#include "tests/support/asl_folder.h"
#include "tests/support/scripted_source.h"
#include "tests/support/temp_dir.h"

namespace facet::asl_sources_test {
namespace {

constexpr int kFrames = 30;

/// A log whose playback is a nanosecond short of its first sample.
template <class Base, class Sample, class Source>
class AslHarness final : public test::SourceHarness<Base, Sample> {
public:
    AslHarness() {
        test::write_asl_folder(dir_, kFrames);
        AslSourceOptions options;
        options.folder = dir_.path();
        // The first inertial sample is a frame before the first frame.
        options.pace.log_begin = {test::kAslBegin - (kIsImu ? test::kAslFrameStep : 0) - 1};
        options.pace.host_begin = clock_.now();
        source_.emplace(clock_, options);
    }

    Base& source() override { return *source_; }
    void offer(int count) override {
        clock_.advance({count * (kIsImu ? test::kAslImuStep : test::kAslFrameStep)});
        offered_ += count;
    }
    test::Hook offer_corrupt() override {
        if (kIsImu) {
            return test::Hook::kCannot;  // rows are read ahead
        }
        // One frame ahead is decoded already.
        dir_.write("mav0/cam0/data/" + test::asl_image_name(offered_ + 1), "no image");
        return test::Hook::kDone;
    }
    test::Hook offer_ahead() override { return test::Hook::kCannot; }   // the log's stamps are the clock
    test::Hook break_device() override { return test::Hook::kCannot; }  // a log that is damaged has ended
    void repair_device() override {}
    test::Hook judges_silence() override { return test::Hook::kCannot; }
    test::Hook end() override {
        clock_.advance(Duration::from_seconds(10.0));
        return test::Hook::kDone;
    }
    void pass_time() override {}
    int held_back() const override { return 1; }

private:
    static constexpr bool kIsImu = std::is_same_v<Base, ImuSource>;

    test::TempDir dir_;
    ManualClock clock_{{5'000'000'000}};
    std::optional<Source> source_;
    int offered_ = 0;
};

TEST_CASE("recorded sources keep the contract of their ports", "[port_conformance]") {
    test::check_source_conformance<test::ImuHarness>(
        [] { return std::make_unique<AslHarness<ImuSource, ImuSample, AslImuSource>>(); });
    test::check_source_conformance<test::StereoHarness>(
        [] { return std::make_unique<AslHarness<StereoSource, StereoFrame, AslStereoSource>>(); });
}

TEST_CASE("played as fast as asked, both sources give the log as the dataset does") {
    const test::TempDir dir;
    test::write_asl_folder(dir, kFrames);
    AslSourceOptions options;
    options.folder = dir.path();
    options.log.frame_delay = Duration::from_seconds(0.02);
    options.pace.as_fast_as_asked = true;
    ManualClock clock;
    AslStereoSource stereo(clock, options);
    AslImuSource imu(clock, options);
    REQUIRE(ok(stereo.start()));
    REQUIRE(ok(imu.start()));
    AslDataset log;
    std::string error;
    REQUIRE(ok(log.open(dir.path(), options.log, {}, error)));
    int frames = 0;
    for (;;) {
        ImuSample sample;
        ImuSample played_sample;
        StereoFrame frame;
        StereoFrame played;
        const AslDataset::Event event = log.next(sample, frame);
        if (event == AslDataset::Event::kEnd) {
            break;
        }
        if (event == AslDataset::Event::kImu) {
            REQUIRE(imu.next({}, played_sample) == Status::kOk);
            REQUIRE(played_sample.stamp == sample.stamp);
            REQUIRE(played_sample.a_B == sample.a_B);
            continue;
        }
        ++frames;
        REQUIRE(stereo.next({}, played) == Status::kOk);
        REQUIRE(played.stamp == frame.stamp);
        REQUIRE(played.right.row(7)[3] == frame.right.row(7)[3]);
        REQUIRE(played.left.row(7)[3] == frame.left.row(7)[3]);
    }
    ImuSample sample;
    StereoFrame frame;
    CHECK(imu.next({}, sample) == Status::kEndOfStream);
    CHECK(stereo.next({}, frame) == Status::kEndOfStream);
    CHECK(frames == kFrames);
}

TEST_CASE("a log without a folder is not there, and stamps can be moved to now") {
    ManualClock clock({77'000'000'000});
    AslSourceOptions options;
    options.folder = "/no/such/folder";
    AslImuSource none(clock, options);
    CHECK(none.start() == Status::kNotFound);
    CHECK(none.problem() == "/no/such/folder: no such folder");

    const test::TempDir dir;
    test::write_asl_folder(dir, 3);
    options.folder = dir.path();
    options.pace = {{test::kAslBegin}, clock.now(), false, false};
    AslStereoSource stereo(clock, options);
    REQUIRE(ok(stereo.start()));
    StereoFrame frame;
    REQUIRE(stereo.next({}, frame) == Status::kOk);
    CHECK(frame.stamp == Timestamp{77'000'000'000});
    CHECK(stereo.next(Duration::from_seconds(0.01), frame) == Status::kNotReady);
    CHECK(stereo.next(Duration::from_seconds(0.1), frame) == Status::kOk);  // waits on the clock
    CHECK(clock.now() == Timestamp{77'050'000'000});
}

}  // namespace
}  // namespace facet::asl_sources_test
