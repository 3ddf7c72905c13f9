// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/dry_run.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <map>

#include "tests/drivers/mavlink/fake_autopilot.h"
#include "tests/support/fake_kernel.h"
#include "tests/support/scripted_source.h"
#include "tests/support/temp_dir.h"

namespace facet::dry_run_test {
namespace {

/// Devices by path: what opening gives. What is opened answers no request; SPI transfers return zeros.
class FakeBench final : public test::FakeKernel {
public:
    std::map<std::string, int> devices;
    int open(const char* path, int) override {
        const auto at = devices.find(path);
        return at == devices.end() ? -ENOENT : at->second;
    }
    int close(int) override { return 0; }
    int ioctl(int fd, unsigned long, void*) override { return fd == kSpi ? 0 : -ENOTTY; }
    std::int64_t write(int fd, const void* data, std::size_t count) override {
        written[fd].emplace_back(static_cast<const char*>(data), count);
        return static_cast<std::int64_t>(count);
    }
    std::map<int, std::vector<std::string>> written;
    int socket(int domain, int, int) override { return domain == 2 ? 40 : -EAFNOSUPPORT; }
    int connect(int, const void*, std::size_t) override { return 0; }

    static constexpr int kSpi = 30;
};

Vehicle spi_vehicle() {
    Vehicle vehicle;
    vehicle.calibration.noise.rate_hz = 200.0;
    for (CameraV4l2Options* camera : {&vehicle.cameras.left, &vehicle.cameras.right}) {
        camera->capture.width = 160;
        camera->capture.height = 120;
    }
    vehicle.cameras.left.capture.device = "/dev/video0";
    vehicle.cameras.right.capture.device = "/dev/video1";
    vehicle.trigger.emplace();
    vehicle.trigger->input.line = {"/dev/gpiochip0", 17, ""};
    vehicle.imu_spi.emplace();
    vehicle.imu_spi->source.name = "adis16448";
    vehicle.mavlink.emplace();
    return vehicle;
}

const ProbeLine& line_of(const std::vector<ProbeLine>& lines, const std::string& device) {
    const auto at = std::find_if(lines.begin(), lines.end(), [&](const ProbeLine& l) { return l.device == device; });
    REQUIRE(at != lines.end());
    return *at;
}

std::vector<ProbeLine> probe(FakeBench& kernel, const Vehicle& vehicle) {
    ManualClock clock({1'000'000'000});
    Hardware hardware(kernel, clock, vehicle);
    return dry_run(hardware, clock, vehicle, Duration::from_seconds(0.5));
}

TEST_CASE("trigger pulses are started before the cameras are asked, and end with the dry run") {
    FakeBench kernel;
    Vehicle vehicle = spi_vehicle();
    vehicle.pulses.emplace();
    vehicle.pulses->pwm_chip = "/sys/class/pwm/pwmchip0";
    std::vector<ProbeLine> lines = probe(kernel, vehicle);
    CHECK(lines.front().device == "pulses");
    CHECK(lines.front().finding == Finding::kWrong);
    CHECK(lines.front().text == "trigger_output: /sys/class/pwm/pwmchip0/export: No such file or directory");
    constexpr int kEnable = 50;
    for (const char* file : {"export", "pwm0/duty_cycle", "pwm0/period"}) {
        kernel.devices[std::string("/sys/class/pwm/pwmchip0/") + file] = 49;
    }
    kernel.devices["/sys/class/pwm/pwmchip0/pwm0/enable"] = kEnable;
    lines = probe(kernel, vehicle);
    CHECK(lines.front().finding == Finding::kGood);
    CHECK(lines.front().text == "20.0/s started");
    CHECK(kernel.written[kEnable] == std::vector<std::string>{"1", "0"});
    vehicle.pulses->pwm_chip.clear();
    vehicle.pulses->line = {"/dev/gpiochip4", 2, ""};
    CHECK(probe(kernel, vehicle).front().text ==
          "trigger_output: /dev/gpiochip4 line 2: the chip cannot be opened: No such file or directory");
}

TEST_CASE("what is not there is named, device by device") {
    FakeBench kernel;
    const std::vector<ProbeLine> lines = probe(kernel, spi_vehicle());
    REQUIRE(lines.size() == 6);
    const struct {
        const char* device;
        const char* text;
    } expected[] = {{"left camera", "/dev/video0: cannot be opened: No such file or directory"},
                    {"right camera", "/dev/video1: cannot be opened: No such file or directory"},
                    {"trigger", "/dev/gpiochip0"},
                    {"imu", "/dev/spidev0.0"}};
    for (const auto& e : expected) {
        INFO(e.device << ": " << line_of(lines, e.device).text);
        CHECK(line_of(lines, e.device).finding == Finding::kWrong);
        CHECK(line_of(lines, e.device).text.find(e.text) != std::string::npos);
    }
    CHECK(line_of(lines, "mavlink").finding == Finding::kGood);
    CHECK(line_of(lines, "system").finding == Finding::kGood);
    const std::string text = to_text(lines);
    CHECK(text.find("WRONG     left camera:  /dev/video0: cannot be opened") != std::string::npos);
    CHECK(text.find("ok        mavlink:      127.0.0.1:14580") != std::string::npos);
}

TEST_CASE("no permission, no camera, and a chip that does not answer are distinguished") {
    FakeBench kernel;
    kernel.devices = {{"/dev/video0", -EACCES}, {"/dev/video1", 8}, {"/dev/spidev0.0", FakeBench::kSpi}};
    const std::vector<ProbeLine> lines = probe(kernel, spi_vehicle());
    CHECK(line_of(lines, "left camera").text.find("Permission denied") != std::string::npos);
    CHECK(line_of(lines, "right camera").text.find("not a video device") != std::string::npos);
    INFO(line_of(lines, "imu").text);
    CHECK(line_of(lines, "imu").finding == Finding::kWrong);
    CHECK(line_of(lines, "imu").text.find("adis16448: ") == 0);
}

TEST_CASE("a CAN interface and a log folder that are not there") {
    const test::TempDir dir;
    FakeBench kernel;
    Vehicle vehicle = spi_vehicle();
    vehicle.imu_spi.reset();
    vehicle.imu_can.emplace();
    vehicle.imu_can->protocol = CanProtocol::kDroneCan;
    vehicle.imu_can->source.socket.interface = "can7";
    vehicle.mavlink.reset();
    dir.write("file", "");
    vehicle.log.folder = dir.file("file/log");
    const std::vector<ProbeLine> lines = probe(kernel, vehicle);
    INFO(line_of(lines, "imu").text);
    CHECK(line_of(lines, "imu").finding == Finding::kWrong);
    CHECK(line_of(lines, "imu").text.find("can7") != std::string::npos);
    CHECK(line_of(lines, "log").finding == Finding::kWrong);
    CHECK(line_of(lines, "mavlink").finding == Finding::kDoubtful);

    vehicle.log.folder = dir.file("log");
    const std::vector<ProbeLine> good = probe(kernel, vehicle);
    CHECK(line_of(good, "log").finding != Finding::kWrong);
    CHECK_FALSE(std::filesystem::exists(dir.file("log/dry_run.tmp")));
}

TEST_CASE("a sensor of the kernel's that is not there is named") {
    FakeBench kernel;
    Vehicle vehicle = spi_vehicle();
    vehicle.imu_spi.reset();
    vehicle.imu_iio.emplace();
    vehicle.imu_iio->gyro = "gyro_3d";
    vehicle.imu_iio->accel = "accel_3d";
    const std::vector<ProbeLine> lines = probe(kernel, vehicle);
    CHECK(line_of(lines, "imu").finding == Finding::kWrong);
    CHECK(line_of(lines, "imu").text == "gyro_3d: no such device in /sys/bus/iio/devices, which has none");
}

TEST_CASE("the flight controller's inertial sensor is heard over the link, and its rounding is judged") {
    ManualClock clock({100'000'000'000});
    test::AutopilotKernel kernel(clock);
    kernel.sends_every = {5'000'000};
    Vehicle vehicle = spi_vehicle();
    vehicle.imu_spi.reset();
    vehicle.trigger.reset();
    vehicle.imu_mavlink.emplace();
    const auto probed = [&] {
        Hardware hardware(kernel, clock, vehicle);
        return dry_run(hardware, clock, vehicle, Duration::from_seconds(0.5));
    };
    const std::vector<ProbeLine> good = probed();
    CAPTURE(to_text(good));
    CHECK(line_of(good, "imu").finding == Finding::kGood);
    CHECK(line_of(good, "imu").text.find("200 samples/s, 0 lost, 0 bad; mean specific force") == 0);
    CHECK(line_of(good, "mavlink").finding == Finding::kGood);
    CHECK(std::none_of(good.begin(), good.end(), [](const ProbeLine& l) { return l.device == "imu noise"; }));
    vehicle.imu_mavlink->message = MavlinkImuMessage::kRawImu;
    vehicle.calibration.noise.accel_noise_m_per_s2_per_sqrt_hz = 1e-4;
    const std::vector<ProbeLine> other = probed();
    CAPTURE(to_text(other));
    CHECK(line_of(other, "imu").finding == Finding::kWrong);
    CHECK(line_of(other, "imu").text.find("none of the readings that were asked for has come") != std::string::npos);
    CHECK(line_of(other, "imu noise").text ==
          "RAW_IMU rounds; at 200 Hz the calibration's noise densities must be 2.0e-05 rad/s/sqrt(Hz) and 2.0e-04 "
          "m/s^2/sqrt(Hz) at least");
}

TEST_CASE("threads that could hold up those of the interrupts are doubtful") {
    FakeBench kernel;
    Vehicle vehicle = spi_vehicle();
    vehicle.realtime.imu.priority = 49;
    const std::vector<ProbeLine> below = probe(kernel, vehicle);
    CHECK(line_of(below, "system").text.find("interrupt threads") == std::string::npos);
    vehicle.realtime.imu.priority = 50;
    vehicle.realtime.output.priority = 60;
    const std::vector<ProbeLine> above = probe(kernel, vehicle);
    CHECK(line_of(above, "system").finding == Finding::kDoubtful);
    CHECK(line_of(above, "system").text.find("priority of imu, output is not below 50") != std::string::npos);
}

}  // namespace
}  // namespace facet::dry_run_test
