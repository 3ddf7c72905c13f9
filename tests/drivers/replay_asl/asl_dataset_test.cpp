// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/replay_asl/asl_dataset.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>

#include "tests/support/asl_folder.h"

namespace facet::asl_dataset_test {
namespace {

using test::asl_image_name;
using test::asl_image_row;
using test::asl_imu_row;
using test::kAslBegin;
using test::kAslFrameStep;
using test::kAslImuStep;

constexpr int kFrames = 6;
constexpr int kSamples = 10 * (kFrames + 1) + 1;

/// What a reader gave and what it complained of.
struct Reading {
    Status status = Status::kOk;
    std::string error;
    std::vector<std::int64_t> frames;     ///< stamps
    std::vector<std::int64_t> left_only;  ///< stamps of frames without a right view
    std::vector<std::int64_t> imu;        ///< stamps
    std::vector<AslWarning> warnings;
    bool in_order = true;  ///< each frame right after the first sample at or after it

    std::size_t count(AslWarningKind kind) const {
        return static_cast<std::size_t>(
            std::count_if(warnings.begin(), warnings.end(), [&](const AslWarning& w) { return w.kind == kind; }));
    }
};

Reading read(const std::string& path, const AslOptions& options = {}) {
    Reading reading;
    AslDataset log;
    reading.status = log.open(
        path, options, [&](const AslWarning& w) { reading.warnings.push_back(w); }, reading.error);
    if (!ok(reading.status)) {
        return reading;
    }
    ImuSample imu;
    StereoFrame frame;
    for (;;) {
        switch (log.next(imu, frame)) {
            case AslDataset::Event::kEnd: return reading;
            case AslDataset::Event::kImu: reading.imu.push_back(imu.stamp.ns); break;
            case AslDataset::Event::kFrame:
                reading.frames.push_back(frame.stamp.ns);
                if (frame.right.empty()) {
                    reading.left_only.push_back(frame.stamp.ns);
                }
                reading.in_order = reading.in_order && !reading.imu.empty() && reading.imu.back() >= frame.stamp.ns &&
                                   (reading.imu.size() < 2 || reading.imu[reading.imu.size() - 2] < frame.stamp.ns);
                break;
        }
    }
}

std::int64_t frame_stamp(int k) { return kAslBegin + k * kAslFrameStep; }

TEST_CASE("a good log gives every frame and sample, in order, without warnings") {
    const test::TempDir dir;
    test::write_asl_folder(dir, kFrames);
    const std::string below = GENERATE("", "mav0", "mav0/");
    const Reading reading = read(dir.file(below));
    REQUIRE(reading.error == "");
    REQUIRE(reading.frames.size() == kFrames);
    CHECK(reading.frames.front() == frame_stamp(0));
    CHECK(reading.left_only.empty());
    CHECK(reading.warnings.empty());
    CHECK(reading.in_order);
    // Samples after the last frame is covered are of no use and not read.
    CHECK(reading.imu.size() == 10 * kFrames + 1);
    CHECK(std::is_sorted(reading.imu.begin(), reading.imu.end()));
}

TEST_CASE("images and samples carry the recorded values") {
    const test::TempDir dir;
    test::write_asl_folder(dir, 2);
    AslDataset log;
    std::string error;
    REQUIRE(log.open(dir.path(), {}, {}, error) == Status::kOk);
    CHECK(log.frame_count() == 2);
    CHECK(log.log_begin().ns == kAslBegin);
    ImuSample imu;
    StereoFrame frame;
    REQUIRE(log.next(imu, frame) == AslDataset::Event::kImu);
    CHECK(imu.w_B == Eigen::Vector3d(0, 0, 0.01));
    CHECK(imu.a_B == Eigen::Vector3d(0, 0, 9.81));
    AslDataset::Event event = AslDataset::Event::kImu;
    for (int k = 0; k < 2; ++k) {
        while ((event = log.next(imu, frame)) == AslDataset::Event::kImu) {
        }
        REQUIRE(event == AslDataset::Event::kFrame);
        REQUIRE(frame.left.width == test::kAslWidth);
        REQUIRE(frame.right.height == test::kAslHeight);
        for (int v = 0; v < test::kAslHeight; ++v) {
            for (int u = 0; u < test::kAslWidth; ++u) {
                REQUIRE(frame.left.at(u, v) == test::asl_pixel(0, k, u, v));
                REQUIRE(frame.right.at(u, v) == test::asl_pixel(1, k, u, v));
            }
        }
    }
    CHECK(log.next(imu, frame) == AslDataset::Event::kEnd);
    CHECK(log.next(imu, frame) == AslDataset::Event::kEnd);
}

TEST_CASE("a log is repeated without a seam: stamps go on, rows beyond a period serve the last turn only") {
    const test::TempDir dir;
    test::write_asl_folder(dir, kFrames);
    constexpr std::int64_t kPeriod = kFrames * kAslFrameStep;
    AslOptions options;
    options.loops = 3;
    options.frame_delay = Duration::from_seconds(0.02);
    const Reading once = read(dir.path());
    const Reading reading = read(dir.path(), options);
    REQUIRE(reading.error == "");
    CHECK(reading.warnings.empty());
    REQUIRE(reading.frames.size() == 3 * kFrames);
    for (int k = 0; k < 3 * kFrames; ++k) {
        CHECK(reading.frames[static_cast<std::size_t>(k)] == frame_stamp(0) + k * kAslFrameStep);
    }
    REQUIRE(reading.imu.size() > 2U * kPeriod / kAslImuStep + once.imu.size());
    for (std::size_t i = 0; i < reading.imu.size(); ++i) {
        CHECK(reading.imu[i] == once.imu.front() + static_cast<std::int64_t>(i) * kAslImuStep);
    }
}

/// One way to spoil a log, and what must come of it. Frame k is on line k + 2 of its table, sample i on line i + 2.
struct BadInput {
    const char* name;
    void (*spoil)(const test::TempDir&);
    AslWarningKind kind;
    const char* file;  ///< named in the warning
    std::int64_t line;
    std::size_t frames;  ///< given in spite of it
    std::size_t left_only;
};

std::string half(const std::string& path) {
    const std::string bytes = test::read_file(path);
    return bytes.substr(0, bytes.size() / 2);
}

const BadInput kBadInputs[] = {
    {"truncated left PNG",
     [](const test::TempDir& d) {
         const std::string name = "mav0/cam0/data/" + asl_image_name(2);
         d.write(name, half(d.file(name)));
     },
     AslWarningKind::kCorruptImage, "cam0/data.csv", 4, 6, 0},
    {"truncated right PNG",
     [](const test::TempDir& d) {
         const std::string name = "mav0/cam1/data/" + asl_image_name(2);
         d.write(name, half(d.file(name)));
     },
     AslWarningKind::kCorruptImage, "cam1/data.csv", 4, 6, 1},
    {"empty left file", [](const test::TempDir& d) { d.write("mav0/cam0/data/" + asl_image_name(0), ""); },
     AslWarningKind::kCorruptImage, "cam0/data.csv", 2, 6, 0},
    {"missing left file",
     [](const test::TempDir& d) { std::filesystem::remove(d.file("mav0/cam0/data/" + asl_image_name(3))); },
     AslWarningKind::kMissingFile, "cam0/data.csv", 5, 6, 0},
    {"missing right file",
     [](const test::TempDir& d) { std::filesystem::remove(d.file("mav0/cam1/data/" + asl_image_name(3))); },
     AslWarningKind::kMissingFile, "cam1/data.csv", 5, 6, 1},
    {"wrong size",
     [](const test::TempDir& d) {
         d.write("mav0/cam0/data/" + asl_image_name(4), test::encode_png(8, 8, 1, 8, std::vector<std::uint16_t>(64)));
     },
     AslWarningKind::kWrongSize, "cam0/data.csv", 6, 6, 0},
    {"no right row", [](const test::TempDir& d) { test::replace_line(d.file("mav0/cam1/data.csv"), 4, ""); },
     AslWarningKind::kMissingRight, "cam0/data.csv", 4, 6, 1},
    {"no left row", [](const test::TempDir& d) { test::replace_line(d.file("mav0/cam0/data.csv"), 4, ""); },
     AslWarningKind::kMissingLeft, "cam1/data.csv", 4, 6, 0},
    {"row without file name",
     [](const test::TempDir& d) {
         test::replace_line(d.file("mav0/cam0/data.csv"), 4, std::to_string(frame_stamp(2)));
     },
     AslWarningKind::kMalformedRow, "cam0/data.csv", 4, 6, 0},
    {"stamp is not a number",
     [](const test::TempDir& d) { test::replace_line(d.file("mav0/cam0/data.csv"), 4, "12ab,x.png"); },
     AslWarningKind::kMalformedRow, "cam0/data.csv", 4, 6, 0},
    {"duplicate stamp",
     [](const test::TempDir& d) { test::replace_line(d.file("mav0/cam0/data.csv"), 4, asl_image_row(1)); },
     AslWarningKind::kDuplicate, "cam0/data.csv", 4, 6, 0},
    {"stamp goes back",
     [](const test::TempDir& d) { test::replace_line(d.file("mav0/cam0/data.csv"), 5, asl_image_row(0)); },
     AslWarningKind::kOutOfOrder, "cam0/data.csv", 5, 6, 0},
    {"stamp far ahead",
     [](const test::TempDir& d) {
         test::replace_line(d.file("mav0/cam0/data.csv"), 5, std::to_string(frame_stamp(900)) + ",x.png");
     },
     AslWarningKind::kOutOfOrder, "cam0/data.csv", 5, 6, 0},
    {"short inertial row",
     [](const test::TempDir& d) { test::replace_line(d.file("mav0/imu0/data.csv"), 20, "5,1,2"); },
     AslWarningKind::kMalformedRow, "imu0/data.csv", 20, 6, 0},
    {"inertial row of text",
     [](const test::TempDir& d) {
         test::replace_line(d.file("mav0/imu0/data.csv"), 20, std::to_string(kAslBegin) + ",0,0,zero,0,0,9.81");
     },
     AslWarningKind::kMalformedRow, "imu0/data.csv", 20, 6, 0},
    {"NaN in an inertial row",
     [](const test::TempDir& d) {
         test::replace_line(d.file("mav0/imu0/data.csv"), 20, std::to_string(kAslBegin) + ",0,0,NaN,0,0,9.81");
     },
     AslWarningKind::kNotFinite, "imu0/data.csv", 20, 6, 0},
    {"infinity in an inertial row",
     [](const test::TempDir& d) {
         test::replace_line(d.file("mav0/imu0/data.csv"), 20, std::to_string(kAslBegin) + ",0,0,0,0,0,-inf");
     },
     AslWarningKind::kNotFinite, "imu0/data.csv", 20, 6, 0},
    {"inertial stamp twice",
     [](const test::TempDir& d) { test::replace_line(d.file("mav0/imu0/data.csv"), 20, asl_imu_row(17)); },
     AslWarningKind::kDuplicate, "imu0/data.csv", 20, 6, 0},
    {"inertial stamp goes back",
     [](const test::TempDir& d) { test::replace_line(d.file("mav0/imu0/data.csv"), 20, asl_imu_row(3)); },
     AslWarningKind::kOutOfOrder, "imu0/data.csv", 20, 6, 0},
};

TEST_CASE("pairs that are apart are one warning with offset and share, and the left camera is used alone") {
    const test::TempDir dir;
    test::write_asl_folder(dir, kFrames);
    const std::int64_t offset_ms = GENERATE(-20, -5, 5, 15, 20);
    for (int k = 1; k < kFrames; ++k) {
        test::replace_line(dir.file("mav0/cam1/data.csv"), k + 2,
                           std::to_string(frame_stamp(k) + offset_ms * 1'000'000) + "," + asl_image_name(k));
    }
    const Reading reading = read(dir.path());
    CHECK(reading.frames.size() == kFrames);
    CHECK(reading.left_only.size() == kFrames - 1);
    REQUIRE(reading.warnings.size() == 1);
    const AslWarning& warning = reading.warnings.front();
    CHECK(warning.kind == AslWarningKind::kApart);
    CHECK(warning.line == 3);
    const std::string offset = (offset_ms < 0 ? "-" : "+") + std::to_string(std::abs(offset_ms)) + ".000";
    CHECK(warning.message.find("in 5 of 6 frames (83.3 %)") != std::string::npos);
    CHECK(warning.message.find(offset + " ms from the left one's (median; " + offset + " to " + offset + ")") !=
          std::string::npos);
    CHECK(warning.message.find("1 ms at most") != std::string::npos);
}

TEST_CASE("bad input: a warning with file and line, the frame or row is skipped, the run goes on") {
    const BadInput& bad = GENERATE(from_range(std::begin(kBadInputs), std::end(kBadInputs)));
    INFO(bad.name);
    const test::TempDir dir;
    test::write_asl_folder(dir, kFrames);
    bad.spoil(dir);
    AslOptions options;
    options.decode_ahead = GENERATE(false, true);
    const Reading reading = read(dir.path(), options);
    REQUIRE(reading.error == "");
    CHECK(reading.frames.size() == bad.frames);
    CHECK(reading.left_only.size() == bad.left_only);
    CHECK(reading.in_order);
    REQUIRE(reading.count(bad.kind) == 1);
    const auto warning = std::find_if(reading.warnings.begin(), reading.warnings.end(),
                                      [&](const AslWarning& w) { return w.kind == bad.kind; });
    CHECK(warning->line == bad.line);
    CHECK(warning->text().starts_with(dir.file("mav0/") + bad.file + ":" + std::to_string(bad.line) + ": "));
    CHECK(std::is_sorted(reading.imu.begin(), reading.imu.end()));
    CHECK(std::adjacent_find(reading.imu.begin(), reading.imu.end()) == reading.imu.end());
}

TEST_CASE("an inertial gap is reported at the row after it, and frames within it are given") {
    const test::TempDir dir;
    test::write_asl_folder(dir, kFrames);
    for (int i = 0; i < 20; ++i) {
        test::replace_line(dir.file("mav0/imu0/data.csv"), 26, "");  // 100 ms, two frames
    }
    const Reading reading = read(dir.path());
    REQUIRE(reading.warnings.size() == 1);
    CHECK(reading.warnings.front().kind == AslWarningKind::kImuGap);
    CHECK(reading.warnings.front().line == 26);
    CHECK(reading.frames.size() == kFrames);
}

TEST_CASE("CRLF, comments, blank lines and a missing last newline change nothing") {
    const test::TempDir dir;
    test::write_asl_folder(dir, kFrames);
    for (const char* name : {"mav0/cam0/data.csv", "mav0/cam1/data.csv", "mav0/imu0/data.csv"}) {
        std::string text;
        for (const char c : test::read_file(dir.file(name))) {
            text += c == '\n' ? std::string("\r\n") : std::string(1, c);
        }
        text.resize(text.size() - 2);
        dir.write(name, "# recorded somewhere\r\n\r\n" + text);
    }
    const Reading reading = read(dir.path());
    CHECK(reading.warnings.empty());
    CHECK(reading.frames.size() == kFrames);
    CHECK(reading.imu.size() == 10 * kFrames + 1);
}

TEST_CASE("a log of one camera has frames with a left view only, and no warnings") {
    const test::TempDir dir;
    test::write_asl_folder(dir, kFrames);
    std::filesystem::remove_all(dir.file("mav0/cam1"));
    const Reading reading = read(dir.path());
    CHECK(reading.error.empty());
    CHECK(reading.left_only.size() == kFrames);
    CHECK(reading.warnings.empty());
}

TEST_CASE("where the left camera is silent, frames have a right view only") {
    const test::TempDir dir;
    test::write_asl_folder(dir, kFrames);
    test::replace_line(dir.file("mav0/cam0/data.csv"), 4, "");
    std::filesystem::remove(dir.file("mav0/cam0/data/" + asl_image_name(4)));
    AslDataset log;
    std::string error;
    REQUIRE(ok(log.open(dir.path(), {}, {}, error)));
    ImuSample imu;
    StereoFrame frame;
    int k = 0;
    for (AslDataset::Event event{}; (event = log.next(imu, frame)) != AslDataset::Event::kEnd;) {
        if (event == AslDataset::Event::kFrame) {
            CAPTURE(k);
            CHECK(frame.stamp.ns == frame_stamp(k));
            CHECK(frame.left.empty() == (k == 2 || k == 4));
            CHECK_FALSE(frame.right.empty());
            ++k;
        }
    }
    CHECK(k == kFrames);
}

TEST_CASE("pairs need stamps within the tolerance") {
    const test::TempDir dir;
    test::write_asl_folder(dir, kFrames);
    const std::int64_t offset = GENERATE(-1'000'000, 1'000'000, -1'000'001, 1'000'001);
    test::replace_line(dir.file("mav0/cam1/data.csv"), 4,
                       std::to_string(frame_stamp(2) + offset) + "," + asl_image_name(2));
    const Reading reading = read(dir.path());
    CHECK(reading.frames.size() == kFrames);
    CHECK(reading.left_only.size() == (std::abs(offset) > 1'000'000 ? 1U : 0U));
    CHECK(reading.count(AslWarningKind::kApart) == reading.left_only.size());
}

TEST_CASE("frames that inertial data does not reach are skipped with a warning") {
    const test::TempDir dir;
    test::write_asl_folder(dir, kFrames);
    // Samples from 10 ms after the first frame to 10 ms before the last one.
    std::string imu;
    for (int i = 12; i < kSamples - 12; ++i) {
        imu += asl_imu_row(i) + "\n";
    }
    dir.write("mav0/imu0/data.csv", imu);
    const Reading reading = read(dir.path());
    CHECK(reading.frames.size() == kFrames - 2);
    REQUIRE(reading.count(AslWarningKind::kUncovered) == 2);
    CHECK(reading.warnings.front().line == 2);
    CHECK(reading.warnings.back().line == kFrames + 1);
}

TEST_CASE("a window gives its frames only, with inertial data from shortly before") {
    const test::TempDir dir;
    test::write_asl_folder(dir, kFrames);
    AslOptions options;
    options.start = Duration::from_seconds(0.1);
    options.length = Duration::from_seconds(0.1);
    options.imu_lead = Duration::from_seconds(0.02);
    const Reading reading = read(dir.path(), options);
    CHECK(reading.frames == std::vector<std::int64_t>{frame_stamp(2), frame_stamp(3), frame_stamp(4)});
    CHECK(reading.imu.front() == frame_stamp(2) - 20'000'000);
    CHECK(reading.imu.back() == frame_stamp(4));
    CHECK(reading.warnings.empty());
}

TEST_CASE("frames wait for the inertial data that the delay asks for, but not beyond their end") {
    const test::TempDir dir;
    test::write_asl_folder(dir, kFrames);
    AslDataset log;
    AslOptions options;
    options.frame_delay = Duration::from_seconds(0.02);
    std::string error;
    REQUIRE(ok(log.open(
        dir.path(), options, [](const AslWarning&) {}, error)));
    ImuSample imu;
    StereoFrame frame;
    int frames = 0;
    for (AslDataset::Event event = log.next(imu, frame); event != AslDataset::Event::kEnd;
         event = log.next(imu, frame)) {
        if (event == AslDataset::Event::kFrame && ++frames < kFrames) {
            CHECK(imu.stamp.ns == frame.stamp.ns + 20'000'000);
        }
    }
    CHECK(frames == kFrames);
}

TEST_CASE("the lead before the first frame does not cut holes between later frames") {
    const test::TempDir dir;
    test::write_asl_folder(dir, kFrames);
    for (const char* name : {"mav0/cam0/data.csv", "mav0/cam1/data.csv"}) {
        for (int i = 0; i < 3; ++i) {
            test::replace_line(dir.file(name), 4, "");
        }
    }
    AslOptions options;
    options.imu_lead = Duration::from_seconds(0.05);
    const Reading reading = read(dir.path(), options);
    REQUIRE(reading.frames.size() == 3);
    for (std::size_t i = 1; i < reading.imu.size(); ++i) {
        REQUIRE(reading.imu[i] - reading.imu[i - 1] == kAslImuStep);
    }
}

TEST_CASE("the camera time shift moves image stamps onto the IMU's clock") {
    const test::TempDir dir;
    test::write_asl_folder(dir, kFrames);
    AslOptions options;
    options.camera_time_shift = Duration::from_seconds(-0.0075);
    const Reading reading = read(dir.path(), options);
    REQUIRE(reading.frames.size() == kFrames);
    CHECK(reading.frames.front() == frame_stamp(0) - 7'500'000);
    CHECK(reading.in_order);
}

TEST_CASE("a missing dataset or table is one error that names the path") {
    const test::TempDir dir;
    test::write_asl_folder(dir, 2);
    CHECK(read(dir.file("none")).error == dir.file("none") + ": no such folder");
    for (const char* table : {"mav0/cam0/data.csv", "mav0/cam1/data.csv", "mav0/imu0/data.csv"}) {
        const std::string content = test::read_file(dir.file(table));
        dir.write(table, "#only a comment\n");
        const Reading empty = read(dir.path());
        CHECK(empty.status == Status::kIo);
        CHECK(empty.error == dir.file(table) + ": holds no valid row");
        std::filesystem::remove(dir.file(table));
        const Reading missing = read(dir.path());
        CHECK(missing.status == Status::kIo);
        CHECK(missing.error == dir.file(table) + ": cannot be read");
        dir.write(table, content);
    }
}

}  // namespace
}  // namespace facet::asl_dataset_test
