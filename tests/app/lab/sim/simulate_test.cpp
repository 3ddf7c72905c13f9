// SPDX-License-Identifier: BSD-2-Clause
// The whole simulator on a tiny run: a complete folder, the same bytes for any number of threads, clear refusals.
#include "app/lab/sim/simulate.h"

#include <unistd.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <vector>

#include "app/lab/sim/default_rig.h"

namespace facet::sim::simulate_test {
namespace {

namespace fs = std::filesystem;

/// A folder of its own that goes away with the test.
class TemporaryFolder {
public:
    explicit TemporaryFolder(const std::string& name)
        : path_(fs::temp_directory_path() / ("facet_sim_" + name + "_" + std::to_string(::getpid()))) {
        fs::remove_all(path_);
    }
    ~TemporaryFolder() { fs::remove_all(path_); }
    std::string path() const { return path_.string(); }

private:
    fs::path path_;
};

SimOptions tiny(const std::string& out) {
    SimOptions o;
    o.out = out;
    o.duration_s = 0.3;
    o.rate_hz = 10.0;
    o.samples = 1;
    o.threads = 1;
    o.texture_size = 64;
    o.stand_s = 0.1;
    return o;
}

std::string read_all(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

std::map<std::string, std::string> contents(const std::string& folder) {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
        if (entry.is_regular_file()) {
            files[fs::relative(entry.path(), folder).string()] = read_all(entry.path());
        }
    }
    return files;
}

std::vector<std::vector<std::string>> rows(const std::string& text) {
    std::vector<std::vector<std::string>> out;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        std::vector<std::string> fields;
        std::istringstream stream(line);
        for (std::string field; std::getline(stream, field, ',');) {
            fields.push_back(field);
        }
        out.push_back(fields);
    }
    return out;
}

TEST_CASE("A run writes a complete dataset folder") {
    const TemporaryFolder folder("complete");
    SimSummary summary;
    std::string error;
    int calls = 0;
    REQUIRE(ok(simulate(
        tiny(folder.path()), [&](int, int total) { calls += total == 8 ? 1 : 0; }, summary, error)));
    CHECK(summary.frames == 4);
    CHECK(calls == 8);
    std::map<std::string, std::string> files = contents(folder.path());
    for (const char* name :
         {"mav0/body.yaml", "mav0/cam0/sensor.yaml", "mav0/cam1/sensor.yaml", "mav0/imu0/sensor.yaml",
          "mav0/state_groundtruth_estimate0/sensor.yaml", "truth/scene.ply", "truth/planes.json", "truth/meta.json"}) {
        CHECK(files.count(name) == 1);
    }
    const auto imu = rows(files["mav0/imu0/data.csv"]);
    const auto truth = rows(files["mav0/state_groundtruth_estimate0/data.csv"]);
    const auto left = rows(files["mav0/cam0/data.csv"]);
    const auto right = rows(files["mav0/cam1/data.csv"]);
    REQUIRE(left.size() == 5);
    CHECK(left == right);
    CHECK(imu.size() == truth.size());
    CHECK(std::all_of(imu.begin(), imu.end(), [](const auto& r) { return r.size() == 7; }));
    CHECK(std::all_of(truth.begin(), truth.end(), [](const auto& r) { return r.size() == 17; }));
    CHECK(std::stoll(imu[1][0]) < std::stoll(left[1][0]));
    CHECK(std::stoll(imu.back()[0]) > std::stoll(left.back()[0]));
    CHECK(std::stoll(imu[2][0]) - std::stoll(imu[1][0]) == 5'000'000);
    for (std::size_t i = 1; i < left.size(); ++i) {
        CHECK((std::stoll(left[i][0]) - std::stoll(imu[1][0])) % 5'000'000 != 0);
        for (const char* camera : {"mav0/cam0/data/", "mav0/cam1/data/"}) {
            const std::string& png = files[camera + left[i][1]];
            REQUIRE(png.size() > 10000);
            CHECK(png.substr(1, 3) == "PNG");
            CHECK(png.substr(png.size() - 8, 4) == "IEND");
            CHECK(static_cast<unsigned char>(png[18]) * 256 + static_cast<unsigned char>(png[19]) == 752);
        }
    }
}

TEST_CASE("The bytes depend on the seed, not on the threads") {
    const TemporaryFolder one("one");
    const TemporaryFolder three("three");
    const TemporaryFolder other("other");
    SimSummary summary;
    std::string error;
    SimOptions options = tiny(one.path());
    REQUIRE(ok(simulate(options, {}, summary, error)));
    options.out = three.path();
    options.threads = 3;
    REQUIRE(ok(simulate(options, {}, summary, error)));
    options.out = other.path();
    options.seed = 2;
    REQUIRE(ok(simulate(options, {}, summary, error)));
    const auto a = contents(one.path());
    CHECK((a == contents(three.path())));
    auto b = contents(other.path());
    CHECK(a.at("truth/scene.ply") == b.at("truth/scene.ply"));
    CHECK(a.at("mav0/imu0/data.csv") != b.at("mav0/imu0/data.csv"));
}

TEST_CASE("Wrong options are refused in one line that names the option") {
    const TemporaryFolder folder("refused");
    SimSummary summary;
    const auto refusal = [&](const SimOptions& options) {
        std::string error;
        CHECK(simulate(options, {}, summary, error) == Status::kInvalidArgument);
        CHECK(error.find('\n') == std::string::npos);
        return error;
    };
    SimOptions o = tiny(folder.path());
    o.scene = "moon";
    CHECK(refusal(o).find("--scene: there is no scene 'moon'") == 0);
    o = tiny(folder.path());
    o.samples = 0;
    CHECK(refusal(o).find("--samples") == 0);
    o = tiny(folder.path());
    o.duration_s = std::nan("");
    CHECK(refusal(o).find("--duration") == 0);
    o = tiny(folder.path());
    o.time_offset_s = 0.1;
    CHECK(refusal(o).find("--time-offset") == 0);
    o = tiny(folder.path());
    o.extrinsic_error_deg = -1.0;
    CHECK(refusal(o).find("--extrinsic-error") == 0);
    o = tiny(folder.path());
    o.stand_s = std::nan("");
    CHECK(refusal(o).find("--stand") == 0);
    o = tiny(folder.path());
    o.exposure_s = 0.11;  // longer than from image to image
    CHECK(refusal(o).find("--exposure") == 0);
    o = tiny(folder.path());
    o.contrast = 1.1;
    CHECK(refusal(o).find("--contrast") == 0);
    o = tiny("");
    CHECK(refusal(o).find("--out") == 0);
    CHECK_FALSE(fs::exists(folder.path()));
}

TEST_CASE("A long exposure blurs what is seen in motion and nothing else") {
    const TemporaryFolder brief("brief");
    const TemporaryFolder lengthy("lengthy");
    SimSummary summary;
    std::string error;
    SimOptions options = tiny(brief.path());
    options.duration_s = 1.0;
    options.rate_hz = 5.0;
    options.samples = 4;
    options.noise = false;
    REQUIRE(ok(simulate(options, {}, summary, error)));
    options.out = lengthy.path();
    options.exposure_s = 0.03;
    REQUIRE(ok(simulate(options, {}, summary, error)));
    auto a = contents(brief.path());
    auto b = contents(lengthy.path());
    const auto images = rows(a["mav0/cam0/data.csv"]);
    REQUIRE(images.size() == 7);
    CHECK(a["mav0/cam0/data/" + images[1][1]] == b["mav0/cam0/data/" + images[1][1]]);  // before take-off
    CHECK(a["mav0/cam0/data/" + images[6][1]] != b["mav0/cam0/data/" + images[6][1]]);
    CHECK(a["mav0/imu0/data.csv"] == b["mav0/imu0/data.csv"]);
    CHECK(a["mav0/state_groundtruth_estimate0/data.csv"] == b["mav0/state_groundtruth_estimate0/data.csv"]);
}

TEST_CASE("A time offset moves the stamps of the images and nothing else") {
    const TemporaryFolder plain("plain");
    const TemporaryFolder shifted("shifted");
    SimSummary summary;
    std::string error;
    SimOptions options = tiny(plain.path());
    REQUIRE(ok(simulate(options, {}, summary, error)));
    options.out = shifted.path();
    options.time_offset_s = -0.004;
    REQUIRE(ok(simulate(options, {}, summary, error)));
    auto a = contents(plain.path());
    auto b = contents(shifted.path());
    CHECK(a["mav0/imu0/data.csv"] == b["mav0/imu0/data.csv"]);
    const auto told = rows(b["mav0/cam0/data.csv"]);
    const auto taken = rows(a["mav0/cam0/data.csv"]);
    REQUIRE(told.size() == taken.size());
    for (std::size_t i = 1; i < told.size(); ++i) {
        CHECK(std::stoll(told[i][0]) - std::stoll(taken[i][0]) == -4'000'000);
        CHECK(b["mav0/cam1/data/" + told[i][1]] == a["mav0/cam1/data/" + taken[i][1]]);
    }
}

/// T_BS of a sensor.yaml.
Eigen::Matrix4d extrinsics(const std::string& yaml) {
    std::string numbers = yaml.substr(yaml.find("data: [") + 7);
    numbers = numbers.substr(0, numbers.find(']'));
    std::replace(numbers.begin(), numbers.end(), ',', ' ');
    std::istringstream stream(numbers);
    Eigen::Matrix4d T;
    for (int i = 0; i < 16; ++i) {
        REQUIRE(stream >> T(i / 4, i % 4));
    }
    return T;
}

TEST_CASE("An extrinsic error turns both cameras as one in the calibration; the truth is beside it") {
    const TemporaryFolder folder("turned");
    SimSummary summary;
    std::string error;
    SimOptions options = tiny(folder.path());
    options.extrinsic_error_deg = 2.0;
    REQUIRE(ok(simulate(options, {}, summary, error)));
    auto files = contents(folder.path());
    Eigen::Matrix4d claimed[2];
    Eigen::Matrix4d real[2];
    for (int camera = 0; camera < 2; ++camera) {
        claimed[camera] = extrinsics(files["mav0/cam" + std::to_string(camera) + "/sensor.yaml"]);
        real[camera] = extrinsics(files["truth/cam" + std::to_string(camera) + "_sensor.yaml"]);
        CHECK((real[camera] - euroc_T_B_C(camera)).norm() < 1e-9);
        const Eigen::Matrix3d turn =
            claimed[camera].topLeftCorner<3, 3>() * real[camera].topLeftCorner<3, 3>().transpose();
        CHECK(Eigen::AngleAxisd(turn).angle() == Approx(2.0 * EIGEN_PI / 180.0).epsilon(1e-6));
    }
    CHECK((claimed[0].inverse() * claimed[1] - real[0].inverse() * real[1]).norm() < 1e-9);
    CHECK((claimed[0] - real[0]).topRightCorner<3, 1>().norm() < 1e-9);
}

TEST_CASE("A calibration error is in the calibration files alone; the truth is beside them") {
    const TemporaryFolder right("right");
    const TemporaryFolder wrong("wrong");
    SimSummary summary;
    std::string error;
    SimOptions options = tiny(right.path());
    REQUIRE(ok(simulate(options, {}, summary, error)));
    options.out = wrong.path();
    options.calibration_error = 1.0;
    REQUIRE(ok(simulate(options, {}, summary, error)));
    auto a = contents(right.path());
    auto b = contents(wrong.path());
    for (const char* camera : {"cam0", "cam1"}) {
        const std::string claimed = "mav0/" + std::string(camera) + "/sensor.yaml";
        CHECK(a[claimed] != b[claimed]);
        CHECK(a[claimed] == b["truth/" + std::string(camera) + "_sensor.yaml"]);
        a.erase(claimed);
        b.erase(claimed);
    }
    a.erase("truth/meta.json");
    CHECK(b["truth/meta.json"].find("\"calibration_error\": 1.0") != std::string::npos);
    b.erase("truth/meta.json");
    CHECK(a == b);
    options.calibration_error = -1.0;
    CHECK(simulate(options, {}, summary, error) == Status::kInvalidArgument);
    CHECK(error.find("--calibration-error") != std::string::npos);
}

TEST_CASE("Gravity is in the inertial samples alone") {
    const TemporaryFolder usual("usual");
    const TemporaryFolder weak("weak");
    SimSummary summary;
    std::string error;
    SimOptions options = tiny(usual.path());
    REQUIRE(ok(simulate(options, {}, summary, error)));
    options.out = weak.path();
    options.gravity_m_per_s2 = 9.78;
    REQUIRE(ok(simulate(options, {}, summary, error)));
    auto a = contents(usual.path());
    auto b = contents(weak.path());
    const auto strong_imu = rows(a["mav0/imu0/data.csv"]);
    const auto weak_imu = rows(b["mav0/imu0/data.csv"]);
    REQUIRE(strong_imu.size() == weak_imu.size());
    for (std::size_t i = 1; i < weak_imu.size(); ++i) {
        Eigen::Vector3d less;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            CHECK(weak_imu[i][1 + axis] == strong_imu[i][1 + axis]);
            less[static_cast<Eigen::Index>(axis)] =
                std::stod(strong_imu[i][4 + axis]) - std::stod(weak_imu[i][4 + axis]);
        }
        CHECK(less.norm() == Approx(0.03).epsilon(1e-6));
    }
    CHECK(b["truth/meta.json"].find("\"gravity_m_per_s2\": 9.78") != std::string::npos);
    for (const char* changed : {"mav0/imu0/data.csv", "truth/meta.json"}) {
        a.erase(changed);
        b.erase(changed);
    }
    CHECK(a == b);
    options.gravity_m_per_s2 = 0.0;
    CHECK(simulate(options, {}, summary, error) == Status::kInvalidArgument);
    CHECK(error.find("--gravity") == 0);
}

TEST_CASE("A fisheye changes the pictures and the calibration, not the flight") {
    const TemporaryFolder pinhole("pinhole");
    const TemporaryFolder fisheye("fisheye");
    SimSummary summary;
    std::string error;
    SimOptions options = tiny(pinhole.path());
    REQUIRE(ok(simulate(options, {}, summary, error)));
    options.out = fisheye.path();
    options.camera = LensKind::kFisheye;
    REQUIRE(ok(simulate(options, {}, summary, error)));
    auto a = contents(pinhole.path());
    auto b = contents(fisheye.path());
    for (const char* same : {"mav0/imu0/data.csv", "mav0/state_groundtruth_estimate0/data.csv", "truth/scene.ply"}) {
        CHECK(a[same] == b[same]);
    }
    for (const std::string camera : {"cam0", "cam1"}) {
        const std::string& yaml = b["mav0/" + camera + "/sensor.yaml"];
        CHECK(yaml == b["truth/" + camera + "_sensor.yaml"]);
        CHECK(yaml.find("distortion_model: equidistant") != std::string::npos);
        CHECK(extrinsics(yaml) == extrinsics(a["mav0/" + camera + "/sensor.yaml"]));
    }
    CHECK(b["truth/meta.json"].find("\"camera\": \"fisheye\"") != std::string::npos);
}

TEST_CASE("Hovering, vibration and the mover show in their files") {
    const TemporaryFolder folder("hover");
    SimSummary summary;
    std::string error;
    SimOptions options = tiny(folder.path());
    options.flight = FlightKind::kHover;
    options.mover = true;
    options.duration_s = 5.0;
    options.rate_hz = 1.0;
    REQUIRE(ok(simulate(options, {}, summary, error)));
    auto files = contents(folder.path());
    CHECK(files["truth/mover.json"].find("\"crossings\"") != std::string::npos);
    CHECK(files["truth/meta.json"].find("\"flight\": \"hover\"") != std::string::npos);
    CHECK(files["truth/meta.json"].find("\"vibration\": \"flight\"") != std::string::npos);
    // Second differences of the vertical force: 0.07 m/s^2 from noise alone, 40 times that from rotors in flight.
    const auto imu = rows(files["mav0/imu0/data.csv"]);
    double sum = 0.0;
    for (std::size_t i = imu.size() - 200; i < imu.size(); ++i) {
        const auto a = [&](std::size_t k) { return std::stod(imu[k][4]); };
        sum += std::pow(a(i) - 2.0 * a(i - 1) + a(i - 2), 2) / 200.0;
    }
    CHECK(std::sqrt(sum) > 1.5);
    CHECK(std::sqrt(sum) < 4.5);
}

TEST_CASE("A folder that is not empty is kept unless forced; forcing keeps what is not ours") {
    const TemporaryFolder folder("kept");
    fs::create_directories(folder.path() + "/mav0/cam0/data");
    std::ofstream(folder.path() + "/mav0/cam0/data/1.png") << "old";
    std::ofstream(folder.path() + "/notes.txt") << "mine";
    SimSummary summary;
    std::string error;
    SimOptions options = tiny(folder.path());
    CHECK(simulate(options, {}, summary, error) == Status::kInvalidArgument);
    CHECK(error.find("is not empty") != std::string::npos);
    CHECK(read_all(folder.path() + "/mav0/cam0/data/1.png") == "old");
    options.force = true;
    REQUIRE(ok(simulate(options, {}, summary, error)));
    CHECK_FALSE(fs::exists(folder.path() + "/mav0/cam0/data/1.png"));
    CHECK(read_all(folder.path() + "/notes.txt") == "mine");
}

}  // namespace
}  // namespace facet::sim::simulate_test
