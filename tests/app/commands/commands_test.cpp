// SPDX-License-Identifier: BSD-2-Clause
// The program's command line: exit codes and what it says, from outside.
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/app/commands/run_program.h"
#include "tests/support/asl_folder.h"
#include "tests/support/temp_dir.h"

namespace facet::commands_test {
namespace {

using test::contains;
using test::count_lines;
using test::Outcome;
using test::run;

/// A vehicle whose devices are nowhere.
std::string write_vehicle(const test::TempDir& dir) {
    return dir.write("vehicle.yaml",
                     "calibration: {euroc: mav0}\n"
                     "cameras: {left: {device: /dev/no_left}, right: {device: /dev/no_right}}\n"
                     "imu: {can: {interface: can_of_nobody, decoder: openimu300}}\n");
}

TEST_CASE("a dry run names every device that is not there") {
    const test::TempDir dir;
    test::write_asl_folder(dir, 3);
    const Outcome probed = run(dir, "run --dry-run --config " + write_vehicle(dir));
    CHECK(probed.code == 2);
    CHECK(contains(probed.out, "left camera:  /dev/no_left: cannot be opened"));
    CHECK(contains(probed.out, "right camera: /dev/no_right: cannot be opened"));
    CHECK(contains(probed.out, "can_of_nobody"));
    CHECK(contains(probed.err, "3 of 5 devices cannot be used"));
}

TEST_CASE("poses in the map of places need a memory of places") {
    const test::TempDir dir;
    test::write_asl_folder(dir, 3);
    const std::string in_map = dir.write(
        "map.yaml", test::read_file(write_vehicle(dir)) + "sinks: {mavlink: {serial: /dev/ttyS9, frame: map}}\n");
    const Outcome without = run(dir, "run --config " + in_map);
    CHECK(without.code == 2);
    CHECK(contains(without.err, "sinks.mavlink.frame: 'map' needs --places or --map"));
    CHECK(count_lines(without.err) == 1);
    const Outcome with = run(dir, "run --places --config " + in_map);
    CHECK(with.code == 2);
    CHECK(!contains(with.err, "--places"));  // but devices that are not there
}

TEST_CASE("check-config describes a vehicle file, or names the first mistake of each of its sections") {
    const test::TempDir dir;
    test::write_asl_folder(dir, 3);
    const Outcome good = run(dir, "check-config " + write_vehicle(dir));
    CHECK(good.code == 0);
    CHECK(contains(good.out, "/dev/no_left and /dev/no_right"));
    CHECK(contains(good.out, "CAN, can_of_nobody"));
    CHECK(contains(good.out, "none: nobody receives the estimates"));
    const std::string path = dir.write("bad.yaml",
                                       "calibration: {euroc: mav0}\n"
                                       "cameras: {rate_hz: fast}\n"
                                       "imu: {}\n"
                                       "sinks: {mavlink: {baud: 1}}\n"
                                       "sink: {}\n");
    const Outcome bad = run(dir, "check-config " + path);
    CHECK(bad.code == 2);
    CHECK(bad.out.empty());
    CHECK(count_lines(bad.err) == 4);
    CHECK(contains(bad.err, path + ":2: cameras.rate_hz: must be a number"));
    CHECK(contains(bad.err, path + ":3: imu: must have one of 'spi', 'can', 'iio', 'serial', 'mavlink' and 'ros2'"));
    CHECK(contains(bad.err, path + ":4: sinks.mavlink.baud: must be within [1200, 4000000], is 1"));
    CHECK(contains(bad.err, path + ":5: sink: unknown key"));
}

TEST_CASE("a link that cannot be opened is named before the replay begins") {
    const test::TempDir dir;
    test::write_asl_folder(dir, 3);
    const struct {
        const char* link;
        const char* complaint;
    } cases[] = {
        {"tcp:127.0.0.1:5760", "--mavlink tcp:127.0.0.1:5760: must be udp:HOST:PORT or serial:DEVICE[:BAUD]"},
        {"udp:127.0.0.1:99999", "'99999' is not a number from 1 to 65535"},
        {"udp:autopilot:14540", "'autopilot:14540' is not an IPv4 address and port"},
        {"serial:/dev/null:9600", "/dev/null: not a serial line"},
    };
    for (const auto& c : cases) {
        const Outcome refused = run(dir, "replay " + dir.path() + " --out " + dir.file("out") + " --mavlink " + c.link);
        INFO(refused.err);
        CHECK(refused.code == 2);
        CHECK(contains(refused.err, c.complaint));
        CHECK_FALSE(std::filesystem::exists(dir.file("out")));
    }
}

TEST_CASE("the help of each command fits 100 columns and has no names of types") {
    const test::TempDir dir;
    for (const char* command : {"", "replay", "run", "record", "eval", "sim", "convert", "calibrate", "calibration",
                                "check-calibration", "check-config", "info"}) {
        INFO(command);
        const Outcome help = run(dir, std::string(command) + " --help");
        CHECK(help.code == 0);
        std::istringstream lines(help.out);
        for (std::string line; std::getline(lines, line);) {
            INFO(line);
            CHECK(line.size() <= 100);
            for (const char* type : {" TEXT", " INT", " FLOAT", " UINT", " ENUM"}) {
                CHECK_FALSE(contains(line, type));
            }
        }
    }
}

TEST_CASE("help, version and info explain the program") {
    const test::TempDir dir;
    const Outcome help = run(dir, "--help");
    CHECK(help.code == 0);
    for (const char* command : {"replay", "run", "eval", "info"}) {
        CHECK(contains(help.out, command));
        CHECK(run(dir, std::string(command) + " --help").code == 0);
    }
    for (const char* option :
         {"--mode", "--out", "--config", "--start", "--duration", "--calibration", "--imu-calibration", "--inject"}) {
        CHECK(contains(run(dir, "replay --help").out, option));
    }
    const Outcome version = run(dir, "--version");
    CHECK(version.code == 0);
    CHECK(version.out.starts_with("facet "));
    for (const char* part : {"\ncommit ", "\ncompiler ", "\ntarget ", "\nbuild ", "-Wall"}) {
        INFO(part);
        CHECK(contains(version.out, part));
    }
    const Outcome info = run(dir, "info");
    CHECK(info.code == 0);
    for (const char* part : {"compiler", "-Wall", "Eigen 3", "Boost 1", "memory", "inertial history", "max_features"}) {
        INFO(part);
        CHECK(contains(info.out, part));
    }
    const Outcome faults = run(dir, "info --faults");
    CHECK(faults.code == 0);
    CHECK(contains(faults.out, "\n  blackout[=CAMERA] "));
    CHECK(!contains(faults.out, "max_features"));
}

TEST_CASE("report is the script of the source tree") {
    const test::TempDir dir;
    const Outcome help = run(dir, "report --help");
    CHECK(help.code == 0);
    CHECK(contains(help.out, "usage: report"));
    const Outcome refused = run(dir, "report " + dir.file("none"));
    CHECK(refused.code == 2);
    CHECK(contains(refused.err, "report: error: " + dir.file("none")));
}

TEST_CASE("bad usage is one line and exit code 2") {
    const test::TempDir dir;
    test::write_asl_folder(dir, 3);
    const std::string replay = "replay " + dir.path() + " --out " + dir.file("out");
    const std::string config = dir.write("bad.yaml", "window:\n  keyfames: 3\n");
    const std::string vehicle = write_vehicle(dir);
    const struct {
        std::string arguments;
        std::string complaint;
    } cases[] = {
        {"", "subcommand"},
        {"fly", "fly"},
        {"--frob", "--frob: no such option"},
        {"sim --seed -1 --out " + dir.file("out"), "--seed: must not be negative"},
        {"run", "--config"},
        {"run --config " + dir.file("no.yaml"), dir.file("no.yaml") + ": cannot be read"},
        {"run --config " + vehicle + " --duration -1", "--duration must not be negative"},
        {"run --config " + vehicle, "imu: can_of_nobody: "},
        {"replay", "DATASET"},
        {"replay " + dir.path(),
         "--out is missing, the folder for the results: facet replay " + dir.path() + " --out result"},
        {"replay " + dir.write("flight.bag", "#ROSBAG V2.0\n") + " --out x",
         "facet convert " + dir.file("flight.bag") + " flight_log"},
        {replay + " --mode x", "--mode x: unknown"},
        {replay + " --start abc", "--start"},
        {replay + " --start nan", "--start must not be negative"},
        {replay + " --start inf", "--start must not be negative"},
        {replay + " --calibration " + dir.write("empty.yaml", ""),
         dir.file("empty.yaml") + ":1: is not a calibration of a known kind"},
        {replay + " --inject fog@8", "--inject 'fog@8': unknown fault 'fog'"},
        {replay + " --inject flash --inject clip@x", "--inject 'clip@x': start 'x' is not a number"},
        {replay + " --duration -1", "--duration must be positive"},
        {replay + " --truth planes", "--truth planes: only --mode spr uses planes"},
        {replay + " --truth bias --inject time_offset=0.005", "--truth: with stamps that --inject has shifted"},
        {replay + " --view-page page.html", "--view-page: needs --view"},
        {replay + " --view-token token", "--view-token: needs --view"},
        {replay + " --view 0.0.0.0:0", "--view 0.0.0.0:0: others could look along: give a --view-token"},
        {replay + " --view here:80", "--view here:80: must be [ADDRESS:]PORT"},
        {replay + " --view 0 --view-token " + dir.file("no.txt"), dir.file("no.txt") + ": no token in its first line"},
        {replay + " --view 0 --view-page " + dir.file("no.html"), dir.file("no.html") + ": cannot be read"},
        {replay + " --start 1000", "no frame between --start"},
        {replay + " --config " + config, config + ":2: window.keyfames: unknown key"},
        {replay + " --set window.keyframes=1000", "--set window.keyframes=1000: must be within [3, 32], is 1000"},
        {replay + " --calibration " + dir.file("no.yaml"), dir.file("no.yaml") + ": cannot be read"},
        {"replay " + dir.file("none") + " --out " + dir.file("out"), dir.file("none") + ": no such folder"},
        {"eval --groundtruth " + dir.path() + " --estimate " + dir.file("none"), dir.file("none") + ": cannot be read"},
    };
    for (const auto& c : cases) {
        INFO(c.arguments);
        const Outcome outcome = run(dir, c.arguments);
        CHECK(outcome.code == 2);
        INFO(outcome.err);
        CHECK(contains(outcome.err, c.complaint));
        CHECK(outcome.err.starts_with("facet: error: "));
        CHECK(count_lines(outcome.err) == 1);
    }
}

TEST_CASE("info --config writes a file that replay accepts") {
    const test::TempDir dir;
    test::write_asl_folder(dir, 3);
    const std::string config = dir.write("default.yaml", run(dir, "info --config").out);
    const Outcome outcome =
        run(dir, "replay " + dir.path() + " --out " + dir.file("out") + " --quiet --config " + config);
    INFO(outcome.err);
    CHECK((outcome.code == 0 || outcome.code == 1));  // three frames need not give an estimate
    CHECK(nlohmann::json::parse(test::read_file(dir.file("out/summary.json")))["frames"] == 3);
}

TEST_CASE("eval compares files, writes JSON, and fails if nothing matches") {
    const test::TempDir dir;
    std::string truth = "#t\n";
    std::string estimate;
    std::string late;
    for (int i = 0; i < 50; ++i) {
        const std::string x = std::to_string(0.1 * i);
        truth += std::to_string(test::kAslBegin + i * test::kAslFrameStep) + "," + x + ",0,0,1,0,0,0\n";
        const std::string seconds = std::to_string(i / 20) + "." + std::to_string(1000 + i % 20 * 50).substr(1);
        estimate += "140000000" + seconds + " " + x + " 5 0 0 0 0 1\n";
        late += "150000000" + seconds + " " + x + " 5 0 0 0 0 1\n";
    }
    dir.write("mav0/state_groundtruth_estimate0/data.csv", truth);
    dir.write("run/trajectory.tum", estimate);
    const std::string late_path = dir.write("late.tum", late);
    const std::string base = "eval --groundtruth " + dir.path() + " --estimate ";
    const Outcome good = run(dir, base + dir.file("run") + " --json " + dir.file("e.json") + " --rpe-lengths 1,3");
    INFO(good.err);
    REQUIRE(good.code == 0);
    CHECK(contains(good.out, "alignment SE(3), no scale"));
    const auto json = nlohmann::json::parse(test::read_file(dir.file("e.json")));
    CHECK(json["matched"] == 50);
    CHECK(json["ate_se3"]["translation_m"]["max"].get<double>() < 1e-6);
    CHECK(json["rpe"].size() == 2);
    CHECK(json["rpe"][1]["length_m"].get<double>() == 3.0);
    CHECK(run(dir, base + late_path).code == 1);
    CHECK(run(dir, base + dir.file("run") + " --rpe-lengths 0").code == 2);
}

TEST_CASE("eval holds a folder's covariances against the truth") {
    const test::TempDir dir;
    std::string truth = "#t\n";
    std::string tum;
    std::string covariance = "stamp_ns,c00\n";
    for (int i = 0; i < 20; ++i) {
        // True and estimated x differ by 0.1 m from the second pose on, for which 0.05 m is claimed.
        const std::string stamp = std::to_string(test::kAslBegin + i * test::kAslFrameStep);
        const std::string rest = ",0,0,1,0,0,0,0.1,0,0,0,0,0,0,0,0\n";
        truth += stamp + "," + std::to_string(0.1 * i) + rest;
        tum += stamp.substr(0, 10) + "." + stamp.substr(10) + " " + std::to_string(0.1 * i + (i > 0 ? 0.1 : 0.0)) +
               " 0 0 0 0 0 1\n";
        covariance += stamp;
        for (int row = 0; row < 9; ++row) {
            for (int column = row; column < 9; ++column) {
                covariance += row == column ? ",0.0025" : ",0";
            }
        }
        covariance += "\n";
    }
    std::string trajectory = "#t\n";
    for (int i = 0; i < 20; ++i) {
        trajectory += std::to_string(test::kAslBegin + i * test::kAslFrameStep) + "," +
                      std::to_string(0.1 * i + (i > 0 ? 0.1 : 0.0)) + ",0,0,1,0,0,0,0.1,0,0,0,0,0,0,0,0\n";
    }
    dir.write("mav0/state_groundtruth_estimate0/data.csv", truth);
    dir.write("run/trajectory.tum", tum);
    dir.write("run/trajectory.csv", trajectory);
    const std::string base =
        "eval --groundtruth " + dir.path() + " --estimate " + dir.file("run") + " --json " + dir.file("e.json");
    CHECK(run(dir, base + " --errors " + dir.file("errors.csv")).code == 2);
    CHECK(run(dir, base).code == 0);
    CHECK_FALSE(nlohmann::json::parse(test::read_file(dir.file("e.json"))).contains("consistency"));

    dir.write("run/covariance.csv", covariance);
    const Outcome good = run(dir, base + " --errors " + dir.file("errors.csv") + " --details " + dir.file("details"));
    INFO(good.err);
    REQUIRE(good.code == 0);
    CHECK(test::read_file(dir.file("details/errors.csv")) == test::read_file(dir.file("errors.csv")));
    CHECK(count_lines(test::read_file(dir.file("details/ate.csv"))) == 21);
    CHECK(contains(test::read_file(dir.file("details/rpe.csv")), "\n1,1400000000000000000,"));
    CHECK(contains(good.out, "consistency of 19 samples (0 unusable)"));
    const auto json = nlohmann::json::parse(test::read_file(dir.file("e.json")));
    const auto& nees = json["consistency"]["nees"];
    CHECK(nees["position"]["mean"].get<double>() == Approx(4.0));
    CHECK(nees["position"]["within_3_sigma"].get<double>() == 1.0);
    CHECK(nees["velocity"]["mean"].get<double>() == Approx(0.0).margin(1e-9));
    CHECK(count_lines(test::read_file(dir.file("errors.csv"))) == 20);
}

TEST_CASE("sim refuses what it cannot make") {
    const test::TempDir dir;
    for (const char* option : {"--flight loop", "--time-offset 1", "--extrinsic-error -1", "--stand -1"}) {
        const Outcome outcome = run(dir, std::string("sim --out ") + dir.file("flight") + " " + option);
        INFO(outcome.err);
        CHECK(outcome.code == 2);
        CHECK(contains(outcome.err, std::string(option).substr(0, std::string(option).find(' '))));
        CHECK(count_lines(outcome.err) == 1);
    }
}

TEST_CASE("check-calibration and calibrate judge a log of a vehicle at rest") {
    const test::TempDir dir;
    test::write_asl_folder(dir, 40);
    const Outcome checked = run(dir, "check-calibration " + dir.path() + " --json " + dir.file("verdicts.json"));
    CHECK(contains(checked.out, "gravity                ok"));
    CHECK(nlohmann::json::parse(test::read_file(dir.file("verdicts.json"))).contains("checks"));
    CHECK(run(dir, "check-calibration " + dir.file("nowhere")).code == 2);

    // Built without its solver, calibrate says so; otherwise it refuses the flight. Nothing is written either way.
    const Outcome calibrated = run(dir, "calibrate " + dir.path() + " --quiet --out " + dir.file("refined"));
    const bool is_built = !contains(calibrated.err, "without Ceres");
    CHECK(calibrated.code == (is_built ? 1 : 2));
    CHECK(count_lines(calibrated.err) == 1);
    CHECK((!is_built || contains(calibrated.err, "nothing written")));
    CHECK_FALSE(std::filesystem::exists(dir.file("refined")));
}

TEST_CASE("check-calibration: the size of other images is wrong, one camera is judged by itself") {
    const test::TempDir dir;
    test::write_asl_folder(dir, 40);
    std::string wide = test::asl_camera_yaml(0);
    wide.replace(wide.find("[160, 120]"), 10, "[200, 120]");
    dir.write("mav0/cam0/sensor.yaml", wide);
    const Outcome other_size = run(dir, "check-calibration " + dir.path());
    CHECK(other_size.code == 1);
    CHECK(contains(other_size.out, "image size             wrong"));
    CHECK(contains(other_size.out, "size is 160x120, not 200x120"));
    dir.write("mav0/cam0/sensor.yaml", test::asl_camera_yaml(0));
    std::filesystem::remove_all(dir.file("mav0/cam1"));
    const Outcome alone = run(dir, "check-calibration " + dir.path());
    INFO(alone.err);
    CHECK(alone.code == 0);
    CHECK(contains(alone.out, "imu axes"));
    CHECK(contains(alone.out, "time offset"));
    CHECK_FALSE(contains(alone.out, "two images"));
}

/// The log above without any calibration, and Kalibr's files for it.
void write_uncalibrated(const test::TempDir& dir) {
    test::write_asl_folder(dir, 40);
    const Outcome converted = run(dir, "calibration " + dir.file("mav0") + " --to kalibr --out " + dir.file("kalibr"));
    REQUIRE(converted.code == 0);
    for (const char* sensor : {"cam0", "cam1", "imu0"}) {
        std::filesystem::remove(dir.file(std::string("mav0/") + sensor + "/sensor.yaml"));
    }
}

TEST_CASE("a log without sensor.yaml is replayed and checked with a calibration that is given") {
    const test::TempDir dir;
    write_uncalibrated(dir);
    const std::string replay = "replay " + dir.path() + " --quiet --min-coverage 0 --out " + dir.file("out");
    const Outcome none = run(dir, replay);
    CHECK(none.code == 2);
    CHECK(contains(none.err, "has no calibration, neither cam0/sensor.yaml nor camchain.yaml: --calibration FILE"));
    const std::string chain = " --calibration " + dir.file("kalibr/camchain-imucam.yaml");
    const Outcome noiseless = run(dir, replay + chain);
    CHECK(noiseless.code != 2);
    CHECK(contains(noiseless.err, "no file says how noisy the IMU is"));
    const Outcome whole = run(dir, replay + chain + " --imu-calibration " + dir.file("kalibr/imu.yaml"));
    CHECK(whole.code != 2);
    CHECK_FALSE(contains(whole.err, "warning"));
    CHECK(run(dir, "check-calibration " + dir.path() + chain).code != 2);
}

TEST_CASE("lists of images become a log that is replayed, under the first argument or --video") {
    const test::TempDir dir;
    write_uncalibrated(dir);
    const std::string imu = dir.file("mav0/imu0/data.csv");
    const std::string left = dir.file("mav0/cam0/data.csv");
    const std::string right = dir.file("mav0/cam1/data.csv");
    const std::string cameras = " --calibration " + dir.file("kalibr/camchain-imucam.yaml") + " --imu-calibration " +
                                dir.file("kalibr/imu.yaml");
    const Outcome made = run(dir, "convert " + left + " --out " + dir.file("log") + " --right " + right + " --imu " +
                                      imu + cameras + " --quiet");
    CHECK(made.err == "");
    CHECK(made.code == 0);
    CHECK(contains(made.out, "left         " + left + ": "));
    CHECK(contains(made.out, "calibration  as given"));
    const Outcome flown =
        run(dir, "replay " + dir.file("log") + " --quiet --min-coverage 0 --out " + dir.file("result"));
    CHECK(flown.code != 2);
    CHECK(run(dir, "convert " + left + " " + dir.file("no")).code == 2);
    CHECK(contains(run(dir, "convert " + left + " " + dir.file("no")).err, "--imu FILE"));
    CHECK(contains(run(dir, "convert " + imu + " " + dir.file("no") + " --imu " + imu).err,
                   "has no column with names of image files"));
    CHECK(run(dir, "convert --video " + left + " --video " + right + " " + dir.file("video") + " --imu " + imu).code ==
          0);
    CHECK(contains(run(dir, "convert " + dir.file("mav0/cam0") + " " + dir.file("no")).err,
                   "is not a log folder: it has neither cam0/data.csv nor mav0/cam0/data.csv; " +
                       dir.file("mav0/cam0/data") + " can be converted, with --imu FILE"));
    CHECK(contains(run(dir, "convert --video " + left).err, "both are needed"));
    CHECK(contains(run(dir, "convert " + left + " " + dir.file("no") + " --left /cam0").err, "--left: names a topic"));
}

TEST_CASE("calibration says what a file holds, and writes it for others") {
    const test::TempDir dir;
    write_uncalibrated(dir);
    const std::string base =
        "calibration " + dir.file("kalibr/camchain-imucam.yaml") + " --imu-calibration " + dir.file("kalibr/imu.yaml");
    const Outcome shown = run(dir, base);
    CHECK(shown.code == 0);
    CHECK(contains(shown.out, "left         160x120 px, pinhole [150, 150, 79.5, 59.5], radtan [-0.1, 0.01, 0, 0]"));
    CHECK(contains(shown.out, "baseline     0.1000 m"));
    CHECK(run(dir, base + " --to opencv --out " + dir.file("cv")).code == 0);
    const std::string opencv = test::read_file(dir.file("cv/stereo.yaml"));
    CHECK(contains(opencv, "M1: !!opencv-matrix\n  rows: 3\n  cols: 3\n  dt: d\n  data: [150, 0, 79.5,"));
    CHECK(contains(opencv, "T: !!opencv-matrix\n  rows: 3\n  cols: 1\n  dt: d\n  data: [-0.1, "));
    CHECK(run(dir, base + " --to euroc --out " + dir.file("again")).code == 0);
    CHECK(run(dir, "calibration " + dir.file("again")).out == shown.out);
    CHECK(run(dir, base + " --to kalibr").code == 2);
    CHECK(run(dir, base + " --to spline --out " + dir.file("no")).code == 2);
    CHECK(run(dir, "calibration " + dir.file("none")).code == 2);
}

TEST_CASE("reports frames outside the IMU's time span") {
    const test::TempDir dir;
    test::write_asl_folder(dir, 10);
    std::string rows;
    for (int i = 0; i < 60; ++i) {
        rows += std::to_string(12'000'000'000 + 5'000'000 * static_cast<std::int64_t>(i)) + ",0,0,0,0,0,9.8\n";
    }
    dir.write("mav0/imu0/data.csv", rows);
    const Outcome outcome = run(dir, "replay " + dir.path() + " --quiet --out " + dir.file("out"));
    CHECK(outcome.code == 1);
    CHECK(contains(outcome.err, "10 outside the time of the inertial samples (are both on one clock?)"));
    CHECK_FALSE(contains(outcome.err, "missing, damaged"));
}

TEST_CASE("ground truth in TUM's format is known by its rows, whatever it is called") {
    const test::TempDir dir;
    std::string tum = "# timestamp tx ty tz qx qy qz qw\n";
    for (int i = 0; i < 40; ++i) {
        tum += std::to_string(1400000000.0 + 0.05 * i) + " " + std::to_string(0.1 * i) + " 0 0 0 0 0 1\n";
    }
    dir.write("run/trajectory.tum", tum);
    for (const char* name : {"truth.tum", "truth.txt", "poses"}) {
        const std::string base = "eval --estimate " + dir.file("run") + " --groundtruth ";
        const Outcome outcome = run(dir, base + dir.write(name, tum));
        INFO(outcome.err);
        CHECK(outcome.code == 0);
    }
}

}  // namespace
}  // namespace facet::commands_test
