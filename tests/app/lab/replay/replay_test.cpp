// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/replay/replay.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "app/lab/replay/calibration_log.h"
#include "drivers/replay_asl/csv_file.h"
#include "tests/support/asl_folder.h"
#include "tests/support/input_error_text.h"
#include "tests/support/temp_dir.h"

namespace facet::replay_test {
namespace {

constexpr int kFrames = 20;

ReplayOptions options_for(const test::TempDir& dir, const std::string& out) {
    ReplayOptions options;
    options.dataset = dir.path();
    options.out = dir.file(out);
    options.calibration = load_euroc_calibration(dir.file("mav0"));
    options.config.imu_noise = options.calibration.noise;
    options.show_progress = false;
    return options;
}

std::size_t rows(const std::string& path) {
    const std::string text = test::read_file(path);
    return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

nlohmann::json summary_of(const std::string& folder) {
    return nlohmann::json::parse(test::read_file(folder + "/summary.json"));
}

TEST_CASE("a replay writes one row a frame and gives the same bytes twice") {
    const test::TempDir dir;
    test::write_asl_folder(dir, kFrames);
    const std::atomic<bool> stop{false};
    const RunSummary run = run_replay(options_for(dir, "a"), stop);
    run_replay(options_for(dir, "b"), stop);
    CHECK(run.frames_listed == kFrames);
    CHECK(run.frames == kFrames);
    CHECK(run.imu_samples >= 10 * kFrames + 1);  // and a few more, for a time offset
    CHECK(run.imu_refused == 0);
    CHECK(run.warnings.empty());
    CHECK(rows(dir.file("a/health.csv")) == kFrames + 1);
    CHECK(rows(dir.file("a/timing.csv")) == kFrames + 1);
    CHECK(rows(dir.file("a/trajectory.tum")) == run.estimates);
    CHECK(rows(dir.file("a/trajectory.csv")) == run.estimates + 1);
    for (const char* name :
         {"trajectory.tum", "trajectory.csv", "health.csv", "planes.csv", "planes.json", "warnings.txt"}) {
        INFO(name);
        CHECK(test::read_file(dir.file(std::string("a/") + name)) ==
              test::read_file(dir.file(std::string("b/") + name)));
    }
    nlohmann::json a = summary_of(dir.file("a"));
    nlohmann::json b = summary_of(dir.file("b"));
    CHECK(a["frames"] == kFrames);
    const nlohmann::json& given = a["cameras"]["given"]["cam1"]["intrinsics_px"];
    CHECK(given[2] == run.rig.right.intrinsics().cx);
    CHECK(
        a["cameras"]["final"]["cam1"]["intrinsics_px"][2].get<double>() ==
        Approx(given[2].get<double>() + a["calibration_corrections"]["right"]["principal_point_px"][0].get<double>()));
    a.erase("timing");
    b.erase("timing");
    CHECK(a == b);
}

TEST_CASE("the summary names the parameters that were changed") {
    const test::TempDir dir;
    test::write_asl_folder(dir, 3);
    const std::atomic<bool> stop{false};
    ReplayOptions options = options_for(dir, "a");
    run_replay(options, stop);
    CHECK_FALSE(summary_of(options.out)["parameters"].contains("regularity.use_gravity"));
    options.config.regularity.use_gravity = false;
    run_replay(options, stop);
    CHECK(summary_of(options.out)["parameters"]["regularity.use_gravity"] == "false");
}

TEST_CASE("the calibration's log has a row for each keyframe with an estimate, and a name for each number") {
    const test::TempDir dir;
    CalibrationLog log(dir.path());
    const FramePipeline pipeline;
    FrameResult result;
    for (const bool is_keyframe : {true, false, true}) {
        for (const bool is_usable : {true, false}) {
            result.output_stamp = result.output_stamp + Duration{7};
            result.is_keyframe = is_keyframe;
            result.is_usable = is_usable;
            log.write(result, pipeline);
        }
    }
    log.close();
    std::istringstream lines(test::read_file(dir.file("calibration.csv")));
    std::vector<std::string> read;
    for (std::string line; std::getline(lines, line);) {
        CHECK(std::count(line.begin(), line.end(), ',') == 2 * kImuScale);
        read.push_back(line.substr(0, line.find(',', line.find(',') + 1)));
    }
    CHECK(read == std::vector<std::string>{"stamp_ns,time_offset", "7,0", "35,0"});
}

TEST_CASE("bad images cost their view, are counted by kind and listed in warnings.txt") {
    const test::TempDir dir;
    test::write_asl_folder(dir, kFrames);
    dir.write("mav0/cam0/data/" + test::asl_image_name(3), "no PNG");
    dir.write("mav0/cam0/data/" + test::asl_image_name(7), "");
    std::filesystem::remove(dir.file("mav0/cam1/data/" + test::asl_image_name(5)));
    test::replace_line(dir.file("mav0/imu0/data.csv"), 40, "garbage");
    const RunSummary run = run_replay(options_for(dir, "out"), std::atomic<bool>{false});
    CHECK(run.frames_listed == kFrames);
    CHECK(run.frames == kFrames);
    CHECK(run.warnings.at("corrupt_image") == 2);
    CHECK(run.warnings.at("missing_file") == 1);
    CHECK(run.warnings.at("malformed_row") == 1);
    const std::string log = test::read_file(dir.file("out/warnings.txt"));
    CHECK(log.find("corrupt_image: " + dir.file("mav0/cam0/data.csv") + ":5: ") != std::string::npos);
    CHECK(log.find("malformed_row: " + dir.file("mav0/imu0/data.csv") + ":40: ") != std::string::npos);
    CHECK(summary_of(dir.file("out"))["warnings_by_kind"]["corrupt_image"] == 2);
}

TEST_CASE("--start and --duration select frames") {
    const test::TempDir dir;
    test::write_asl_folder(dir, kFrames);
    ReplayOptions options = options_for(dir, "out");
    options.start_s = 0.2;
    options.duration_s = 0.25;
    CHECK(run_replay(options, std::atomic<bool>{false}).frames == 6);
    options.start_s = 100.0;
    CHECK(test::input_error_text([&] { run_replay(options, std::atomic<bool>{false}); }) ==
          dir.path() + ": no frame between --start and its --duration");
}

TEST_CASE("passes follow each other with a seam and no stamp twice") {
    const test::TempDir dir;
    test::write_asl_folder(dir, kFrames);
    ReplayOptions options = options_for(dir, "out");
    options.passes = 3;
    options.faults.push_back(parse_fault("no_right@0.1+0.2"));
    const RunSummary run = run_replay(options, std::atomic<bool>{false});
    CHECK(run.frames_listed == 3 * kFrames);
    CHECK(run.frames == 3 * kFrames);
    CHECK(run.imu_refused == 0);
    CHECK(run.warnings.empty());  // the fault met samples in each pass
    std::istringstream health(test::read_file(dir.file("out/health.csv")));
    std::string row;
    std::getline(health, row);
    std::int64_t before_ns = 0;
    int carried = 0;
    while (std::getline(health, row)) {
        const std::int64_t stamp_ns = std::stoll(row);
        CHECK(stamp_ns > before_ns);
        CHECK((before_ns == 0 || stamp_ns - before_ns < kSeam.ns));
        carried += row.find("no_images") != std::string::npos ? 1 : 0;
        before_ns = stamp_ns;
    }
    CHECK(carried >= 2);  // without frames, in the seams
}

TEST_CASE("a log that ends as it began is repeated without a seam, faults included") {
    const test::TempDir dir;
    test::write_asl_folder(dir, kFrames);
    ReplayOptions options = options_for(dir, "out");
    options.loops = 3;
    options.faults.push_back(parse_fault("imu_noise=1"));
    const RunSummary run = run_replay(options, std::atomic<bool>{false});
    CHECK(run.frames_listed == 3 * kFrames);
    CHECK(run.frames == 3 * kFrames);
    CHECK(run.frames_refused == 0);
    CHECK(run.imu_refused == 0);
    CHECK(run.last.health.imu_gaps == 0);
    std::istringstream health(test::read_file(dir.file("out/health.csv")));
    std::string row;
    std::getline(health, row);
    for (int k = 0; std::getline(health, row); ++k) {
        CHECK(std::stoll(row) == test::kAslBegin + k * test::kAslFrameStep);
    }
}

TEST_CASE("faults reach the estimator, are in the summary, and leave the files comparable") {
    const test::TempDir dir;
    test::write_asl_folder(dir, kFrames);
    ReplayOptions options = options_for(dir, "out");
    // Times count from --start: the first fault meets frames 4 and 5 of the log, the second none.
    options.start_s = 0.1;
    options.faults = {parse_fault("no_left@0.1+0.1"), parse_fault("blackout@50+1"), parse_fault("clock_jump=100@0.5")};
    const RunSummary run = run_replay(options, std::atomic<bool>{false});
    CHECK(run.frames_listed == kFrames - 2);
    CHECK(run.frames == kFrames - 2);
    CHECK(run.warnings.at("idle_fault") == 1);
    CHECK(test::read_file(dir.file("out/warnings.txt")).find("--inject 'blackout@50+1' met no sample") !=
          std::string::npos);
    CHECK(summary_of(dir.file("out"))["faults"] ==
          nlohmann::json::array({"no_left@0.1+0.1", "blackout@50+1", "clock_jump=100@0.5"}));
    const std::string health = test::read_file(dir.file("out/health.csv"));
    const auto has_frame = [&](int k) {
        return health.find("\n" + std::to_string(test::kAslBegin + k * test::kAslFrameStep) + ",") != std::string::npos;
    };
    CHECK(has_frame(3));
    CHECK(has_frame(4));  // the right camera's view is left
    CHECK(has_frame(5));
    CHECK(has_frame(6));
    CHECK(has_frame(kFrames - 1));  // after the jump, under the log's stamp

    options = options_for(dir, "shifted");
    options.faults = {parse_fault("time_offset=0.003")};
    run_replay(options, std::atomic<bool>{false});
    CHECK(test::read_file(dir.file("shifted/health.csv"))
              .find("\n" + std::to_string(test::kAslBegin + 3'000'000) + ",") != std::string::npos);
}

TEST_CASE("a refused configuration is named") {
    const test::TempDir dir;
    test::write_asl_folder(dir, 2);
    ReplayOptions options = options_for(dir, "out");
    options.config.frontend.window_px = 20;  // even: within the range, but refused
    CHECK(test::input_error_text([&] { run_replay(options, std::atomic<bool>{false}); }) ==
          "frontend: window_px must be odd");
}

TEST_CASE("a stop request ends the run with complete files") {
    const test::TempDir dir;
    test::write_asl_folder(dir, kFrames);
    const RunSummary run = run_replay(options_for(dir, "out"), std::atomic<bool>{true});
    CHECK(run.interrupted);
    CHECK(run.frames == 0);
    CHECK(rows(dir.file("out/health.csv")) == 1);
    CHECK(summary_of(dir.file("out"))["interrupted"] == true);
}

TEST_CASE("a dataset or output folder that cannot be used is named") {
    const test::TempDir dir;
    test::write_asl_folder(dir, 2);
    ReplayOptions options = options_for(dir, "out");
    options.dataset = dir.file("none");
    CHECK(test::input_error_text([&] { run_replay(options, std::atomic<bool>{false}); }) ==
          dir.file("none") + ": no such folder");
    options = options_for(dir, "file/below");
    dir.write("file", "");
    CHECK(test::input_error_text([&] {
              run_replay(options, std::atomic<bool>{false});
          }).starts_with(dir.file("file/below") + ": cannot be created"));
}

TEST_CASE("the last frame gets the inertial samples behind it that it waits for") {
    const test::TempDir dir;
    test::write_asl_folder(dir, kFrames);
    ReplayOptions options = options_for(dir, "a");
    options.faults = {parse_fault("time_offset=0.02")};  // its stamp is 20 ms late, the log ends 50 ms behind
    const RunSummary run = run_replay(options, std::atomic<bool>{false});
    CHECK(run.frames == kFrames);
    CHECK(run.frames_not_ready == 0);
    // No more than it needs: the log goes on no further than the frame.
    options = options_for(dir, "b");
    CHECK(run_replay(options, std::atomic<bool>{false}).imu_samples < run.imu_samples);
}

TEST_CASE("an IMU's scale and misalignment are taken out of its samples") {
    const test::TempDir dir;
    test::write_asl_folder(dir, kFrames);
    ReplayOptions plain = options_for(dir, "plain");
    run_replay(plain, std::atomic<bool>{false});
    // The same log as a sensor would have recorded it whose accelerometer reads twice the force: exact in binary.
    const Eigen::Matrix3d M_a = 2.0 * Eigen::Matrix3d::Identity();
    std::string rows;
    for (int i = 0; i < 10 * (kFrames + 1) + 1; ++i) {
        rows += std::to_string(test::kAslBegin - test::kAslFrameStep + i * test::kAslImuStep) + ",0,0,0.01,0,0," +
                std::to_string(2.0 * 9.81) + "\n";
    }
    dir.write("mav0/imu0/data.csv", rows);
    ReplayOptions scaled = options_for(dir, "scaled");
    scaled.config.imu_model = ImuModel(M_a, Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Zero());
    run_replay(scaled, std::atomic<bool>{false});
    CHECK(test::read_file(dir.file("scaled/health.csv")) == test::read_file(dir.file("plain/health.csv")));
    scaled.config.imu_model = {};
    scaled.out = dir.file("dropped");
    run_replay(scaled, std::atomic<bool>{false});
    CHECK(test::read_file(dir.file("dropped/health.csv")) != test::read_file(dir.file("plain/health.csv")));
}

TEST_CASE("a reading is clipped by what the sensor gave, not by what is made of it") {
    const test::TempDir dir;
    test::write_asl_folder(dir, kFrames);  // 9.81 m/s^2 upwards
    const auto clipped = [&](const char* out, double scale, double range) {
        ReplayOptions options = options_for(dir, out);
        options.config.imu_model =
            ImuModel(scale * Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Zero());
        options.config.imu_limits.accel_range_m_per_s2 = range;
        run_replay(options, std::atomic<bool>{false});
        CsvFile health;
        REQUIRE(health.open(dir.file(std::string(out) + "/health.csv"),
                            std::make_unique<std::istringstream>(
                                test::read_file(dir.file(std::string(out) + "/health.csv")).substr(1))));
        std::vector<std::string_view> fields;
        REQUIRE(health.next(fields));
        const auto column = std::find(fields.begin(), fields.end(), "imu_clipped") - fields.begin();
        std::string last;
        while (health.next(fields)) {
            last = std::string(fields.at(static_cast<std::size_t>(column)));
        }
        return last != "0";
    };
    CHECK_FALSE(clipped("a", 1.0, 12.0));
    CHECK_FALSE(clipped("b", 0.8, 12.0));  // stands for 12.3 m/s^2
    CHECK(clipped("c", 1.25, 10.0));       // stands for 7.8 m/s^2
}

}  // namespace
}  // namespace facet::replay_test
