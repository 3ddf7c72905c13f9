// SPDX-License-Identifier: BSD-2-Clause
#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "app/output/coverage.h"
#include "app/output/frame_log.h"
#include "app/output/residual_log.h"
#include "app/output/summary.h"
#include "app/output/trajectory_writer.h"
#include "tests/support/temp_dir.h"

namespace facet::output_test {
namespace {

std::vector<std::string> lines(const std::string& path) {
    std::istringstream stream(test::read_file(path));
    std::vector<std::string> result;
    for (std::string line; std::getline(stream, line);) {
        result.push_back(line);
    }
    return result;
}

std::size_t columns(const std::string& row) {
    return static_cast<std::size_t>(std::count(row.begin(), row.end(), ',')) + 1;
}

Estimate sample_estimate() {
    Estimate e;
    e.stamp.ns = 1403636580838555648;
    e.state.p_W_B = {1.5, -2.25, 1e-9};
    e.state.q_W_B = Eigen::Quaterniond(0.8, 0.6, 0.0, 0.0);
    e.state.v_W_B = {1, 2, 3};
    e.state.bias.gyro = {0.01, 0.02, 0.03};
    e.state.bias.accel = {0.1, 0.2, 0.3};
    e.covariance(0, 0) = 4.0;
    e.covariance(0, 1) = e.covariance(1, 0) = 0.5;
    return e;
}

TEST_CASE("TUM seconds are exact to the nanosecond") {
    const test::TempDir dir;
    TrajectoryWriter writer(dir.path());
    Estimate e = sample_estimate();
    for (const std::int64_t ns : {std::int64_t{1403636580838555648}, std::int64_t{5}, std::int64_t{-1'500'000'000},
                                  std::int64_t{0}, std::numeric_limits<std::int64_t>::min()}) {
        e.stamp.ns = ns;
        writer.write(e);
    }
    writer.close();
    const std::vector<std::string> rows = lines(dir.file("trajectory.tum"));
    REQUIRE(rows.size() == 5);
    CHECK(rows[0].starts_with("1403636580.838555648 "));
    CHECK(rows[1].starts_with("0.000000005 "));
    CHECK(rows[2].starts_with("-1.500000000 "));
    CHECK(rows[3].starts_with("0.000000000 "));
    CHECK(rows[4].starts_with("-9223372036.854775808 "));
}

TEST_CASE("trajectories follow the TUM and EuRoC column orders") {
    const test::TempDir dir;
    TrajectoryWriter writer(dir.path());
    writer.write(sample_estimate());
    writer.close();
    CHECK(
        test::read_file(dir.file("trajectory.tum")) ==
        "1403636580.838555648 1.500000000 -2.250000000 0.000000001 0.600000000 0.000000000 0.000000000 0.800000000\n");
    const std::vector<std::string> covariance = lines(dir.file("covariance.csv"));
    REQUIRE(covariance.size() == 2);
    CHECK(covariance[0].starts_with("stamp_ns,c00,c01,"));
    CHECK(covariance[0].ends_with(",c77,c78,c88"));
    CHECK(columns(covariance[1]) == 46);
    CHECK(covariance[1].starts_with("1403636580838555648,4.000000e+00,5.000000e-01,0.000000e+00,"));
    const std::vector<std::string> rows = lines(dir.file("trajectory.csv"));
    REQUIRE(rows.size() == 2);
    CHECK(rows[0].starts_with("#timestamp"));
    CHECK(columns(rows[0]) == 17);
    CHECK(
        rows[1] ==
        "1403636580838555648,1.500000000,-2.250000000,0.000000001,0.800000000,0.600000000,0.000000000,0.000000000,"
        "1.000000000,2.000000000,3.000000000,0.010000000,0.020000000,0.030000000,0.100000000,0.200000000,0.300000000");
}

TEST_CASE("health.csv has a column for every field and names the reasons") {
    const test::TempDir dir;
    HealthWriter writer(dir.path());
    Health h;
    h.state = TrackingState::kDegraded;
    h.reasons = kReasonFewStereo | kReasonImuGap | (1U << 31);
    h.is_keyframe = true;
    h.tracked = 1;
    h.detected = 2;
    h.stereo = 3;
    h.outliers = 4;
    h.fixed_share = 0.25;
    h.keyframes = 5;
    h.landmarks = 6;
    h.landmarks_dropped = 11;
    h.iterations = 7;
    h.map_landmarks = 10;
    h.frame_chi2 = 0.75;
    h.mean_vision_chi2 = 0.5;
    h.pixel_sigma_px = 0.35;
    h.residual_bias_px = 0.02;
    h.calibration_stretch = 1.5;
    h.calibration_scale = 0.4;
    h.imu_chi2 = 1.25;
    h.imu_gaps = 8;
    h.imu_dropped = 9;
    writer.write({42}, h);
    writer.close();
    const std::vector<std::string> rows = lines(dir.file("health.csv"));
    REQUIRE(rows.size() == 2);
    CHECK(rows[0] ==
          "stamp_ns,state,reasons,reason_names,quality,reset_counter,is_keyframe,is_exchanged,is_still,tracked,"
          "detected,stereo,"
          "recalled,outliers,fixed_share,keyframes,landmarks,landmarks_dropped,"
          "iterations,map_landmarks,frame_chi2,"
          "mean_vision_chi2,pixel_sigma_px,residual_bias_px,calibration_stretch,calibration_scale,imu_chi2,"
          "time_offset_s,time_offset_sigma_s,imu_gaps,imu_clipped,imu_dropped");
    CHECK(rows[1] ==
          "42,DEGRADED,2147483658,few_stereo|imu_gap|bit31,0,0,1,0,0,1,2,3,0,4,0.25,5,6,11,7,10,0.75,0.5,"
          "0.35,0.02,1.5,0.4,1.25,0,0,8,0,9");
    CHECK(reason_names(0).empty());
}

TEST_CASE("residuals.csv counts each coordinate's residuals") {
    const test::TempDir dir;
    VisionResiduals residuals;
    for (const double px : {0.0, 0.02, -0.03, 1.0, 50.0}) {
        residuals.right_v.add(px);
    }
    CHECK(residuals.right_v.total() == 5);
    CHECK(residuals.right_v.mean_px() == Approx(50.99 / 5));
    write_residuals(residuals, dir.path());
    const std::vector<std::string> rows = lines(dir.file("residuals.csv"));
    REQUIRE(rows.size() == 1 + ResidualHistogram::kBins);
    CHECK(rows[0] == "bin_px,left_u,left_v,right_u,right_v");
    CHECK(rows[1] == "-2.00,0,0,0,0");
    CHECK(rows[40] == "-0.05,0,0,0,1");
    CHECK(rows[41] == "0.00,0,0,0,2");
    CHECK(rows[61] == "1.00,0,0,0,1");
    CHECK(rows[81] == "2.00,0,0,0,0");
}

TEST_CASE("timing.csv has a column for every stage") {
    const test::TempDir dir;
    TimingWriter writer(dir.path());
    FrameTiming timing;
    timing.total = {10.0, 8.0};
    timing.estimate = {6.0, 5.0};
    timing.stages[static_cast<std::size_t>(Stage::kSolve)] = {2.5, 2.0};
    writer.write({42}, true, timing);
    writer.close();
    const std::vector<std::string> rows = lines(dir.file("timing.csv"));
    REQUIRE(rows.size() == 2);
    CHECK(rows[0] ==
          "stamp_ns,is_keyframe,total_ms,estimate_ms,propagation_ms,tracking_ms,frame_update_ms,triangulation_ms,"
          "linearization_ms,solve_ms,marginalization_ms,landmarks_ms,mesh_ms,planes_ms,depth_ms,places_ms,total_cpu_ms,"
          "estimate_cpu_ms,propagation_cpu_ms,tracking_cpu_ms,frame_update_cpu_ms,triangulation_cpu_ms,"
          "linearization_cpu_ms,solve_cpu_ms,marginalization_cpu_ms,landmarks_cpu_ms,mesh_cpu_ms,planes_cpu_ms,"
          "depth_cpu_ms,places_cpu_ms");
    CHECK(rows[1] ==
          "42,1,10.0000,6.0000,0.0000,0.0000,0.0000,0.0000,0.0000,2.5000,0.0000,0.0000,0.0000,0.0000,0.0000,0.0000,"
          "8.0000,5.0000,0.0000,0.0000,0.0000,0.0000,0.0000,2.0000,0.0000,0.0000,0.0000,0.0000,0.0000,0.0000");
    CHECK(columns(rows[0]) == 2 + 2 * (2 + kStageCount));
}

TEST_CASE("timing statistics are order statistics") {
    std::vector<double> times;
    for (int i = 200; i >= 1; --i) {
        times.push_back(i);
    }
    const TimingStatistics s = timing_statistics(times);
    CHECK(s.count == 200);
    CHECK(s.median_ms == 100.5);
    CHECK(s.p99_ms == 198.0);
    CHECK(s.max_ms == 200.0);
    CHECK(s.mean_ms == Approx(100.5));
    CHECK(timing_statistics({3.0}).p99_ms == 3.0);
    CHECK(timing_statistics({}).count == 0);
}

TEST_CASE("summary.json differs between runs under timing only") {
    const test::TempDir dir;
    RunSummary run;
    run.dataset = "logs/a";
    run.mode = "s";
    run.frames_listed = 10;
    run.frames = 9;
    run.estimates = 8;
    run.frames_by_state = {{"INIT", 1}, {"TRACKING", 8}};
    run.keyframes = 2;
    run.warnings = {{"imu_gap", 2}, {"corrupt_image", 1}};
    run.last = sample_estimate();
    run.last.health.state = TrackingState::kTracking;
    run.timed = {{true, {}}, {false, {}}};
    const auto write = [&](double total_ms, double wall_s) {
        run.timed[0].timing.total = {total_ms, 0.5 * total_ms};
        run.wall_s = wall_s;
        write_summary(run, dir.path());
        return nlohmann::json::parse(test::read_file(dir.file("summary.json")));
    };
    auto first = write(30.0, 1.0);
    auto second = write(50.0, 2.0);
    CHECK(first["coverage"].get<double>() == 0.8);
    CHECK(first["warnings"] == 3);
    CHECK(first["warnings_by_kind"]["imu_gap"] == 2);
    CHECK(first["frames_by_state"]["TRACKING"] == 8);
    CHECK(first["final"]["state"] == "TRACKING");
    CHECK(first["final"]["quaternion_xyzw"][3].get<double>() == 0.8);
    CHECK_FALSE(first["version"].get<std::string>().empty());
    CHECK(first["timing"]["keyframe"]["median"].get<double>() == 30.0);
    CHECK(first["timing"]["processor"]["keyframe"]["median"].get<double>() == 15.0);
    CHECK(first["timing"]["tracked"]["count"] == 1);
    CHECK(first["timing"]["all"]["count"] == 2);
    CHECK(first != second);
    first.erase("timing");
    second.erase("timing");
    CHECK(first == second);
}

TEST_CASE("a run that has lost too much of its log says how much, and where it went") {
    RunSummary run;
    run.frames_listed = 160;
    run.frames = 160;
    run.estimates = 150;
    run.frames_before_estimate = 10;
    CHECK(describe_lost_coverage(run, 0.8).empty());  // before the start there is none
    run.estimates = 10;
    run.frames_refused = 140;
    CHECK(describe_lost_coverage(run, 0.8) ==
          "only 10 of 160 frames have an estimate, 6.7 % of those since the first: 140 refused by the estimator for "
          "their stamps or size, 10 while the estimator was starting or lost");
    CHECK(describe_lost_coverage(run, 0.05).empty());
    // A late start that then holds: a third of all frames is not enough either.
    run.frames_refused = 0;
    run.estimates = 48;
    run.frames_before_estimate = 112;
    CHECK(describe_lost_coverage(run, 0.8).starts_with("only 48 of 160 frames have an estimate, 100.0 % of those"));
    // Of a table that runs backwards one row is left.
    RunSummary reversed;
    reversed.frames_listed = 160;
    reversed.rows_skipped = 159;
    reversed.frames = reversed.estimates = 1;
    CHECK(describe_lost_coverage(reversed, 0.8) ==
          "only 1 of 160 frames have an estimate, 0.6 % of those since the first: 159 rows of cam0/data.csv skipped");
    RunSummary holes;
    holes.frames_listed = 100;
    holes.frames = holes.estimates = 70;
    CHECK(describe_lost_coverage(holes, 0.8)
              .ends_with(": 30 did not come (image missing, damaged, of another size, or a fault)"));
    holes.warnings["uncovered_frame"] = 20;
    CHECK(
        describe_lost_coverage(holes, 0.8)
            .ends_with(": 20 outside the time of the inertial samples (are both on one clock?), 10 did not come (image "
                       "missing, damaged, of another size, or a fault)"));
    CHECK(describe_lost_coverage({}, 0.0).starts_with("no estimate at all of 0 frames"));
}

}  // namespace
TEST_CASE("a run whose sensors contradict each other most of the time says so") {
    RunSummary run;
    run.frames = 160;
    run.frames_before_estimate = 10;
    run.frames_contradicted = 75;
    CHECK(describe_contradiction(run).empty());
    run.frames_contradicted = 76;
    CHECK(describe_contradiction(run).starts_with(
        "images and inertial samples contradict each other in 76 of 150 frames"));
    CHECK(describe_contradiction(run).find("pattern") == std::string::npos);
    run.frames_fixed_pattern = 1;
    CHECK(describe_contradiction(run).find("pattern that was seen to move with the vehicle") != std::string::npos);
    CHECK(describe_contradiction({}).empty());
}

}  // namespace facet::output_test
