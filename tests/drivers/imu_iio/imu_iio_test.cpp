// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/imu_iio/imu_iio.h"

#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "platform/linux/linux_clock.h"
#include "platform/linux/linux_kernel_io.h"
#include "tests/drivers/imu_iio/fake_iio.h"
#include "tests/port_conformance/source_conformance.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/temp_dir.h"

namespace facet::imu_iio_test {
namespace {

constexpr std::int64_t kPeriodNs = 5'000'000;
constexpr std::int64_t kHourNs = 3'600'000'000'000;
constexpr std::int64_t kEpochNs = 1'700'000'000'000'000'000;
constexpr const char* kGyro = "iio:device3";
constexpr const char* kAccel = "iio:device1";

ImuIioOptions options_of(const std::string& gyro, const std::string& accel) {
    ImuIioOptions options;
    options.gyro = gyro;
    options.accel = accel;
    options.silence = Duration::from_seconds(1.0);
    return options;
}

/// One device with both quantities: 16 bits each, big-endian rates.
class OneDevice : public test::ImuHarness {
public:
    OneDevice() : OneDevice(options_of("imu", "imu")) {}
    explicit OneDevice(const ImuIioOptions& options) : imu(kernel, clock, options) {
        kernel.add_device(kGyro, "imu", 6);
        kernel.add_axes(kGyro, "in_anglvel", 0, "be:s16/16>>0", "0.001");
        kernel.add_axes(kGyro, "in_accel", 3, "le:s16/16>>0", "0.01");
    }

    std::vector<std::uint8_t> scan(std::int64_t stamp_ns) const {
        return test::ScanBytes().add({1000, 0, -500}, 2, true).add({0, 0, 981}, 2).add(stamp_ns, 8);
    }
    ImuSource& source() override { return imu; }
    void offer(int count) override {
        for (int i = 0; i < count; ++i) {
            clock.advance({kPeriodNs});
            kernel.push(kGyro, scan(clock.now().ns));
        }
    }
    test::Hook offer_corrupt() override {
        kernel.push(kGyro, {1, 2, 3});
        return test::Hook::kDone;
    }
    test::Hook offer_ahead() override {
        kernel.push(kGyro, scan(clock.now().ns + kHourNs));
        return test::Hook::kDone;
    }
    test::Hook break_device() override {
        kernel.unplug(kGyro);
        return test::Hook::kDone;
    }
    void repair_device() override { kernel.plug(kGyro); }
    test::Hook judges_silence() override { return test::Hook::kDone; }
    test::Hook end() override { return test::Hook::kCannot; }
    void pass_time() override { clock.advance(Duration::from_seconds(0.6)); }
    int held_back() const override { return 0; }

    ManualClock clock{{20'000'000'000}, {kEpochNs}};
    test::FakeIio kernel{clock};
    ImuIio imu;
};

/// Gyroscope and accelerometer as two devices with formats of their own; forces 1 ms after the rates.
class TwoDevices : public test::ImuHarness {
public:
    TwoDevices() : TwoDevices(options_of("gyro_3d", "accel_3d")) {}
    explicit TwoDevices(const ImuIioOptions& options) : imu(kernel, clock, options) {
        kernel.add_device(kGyro, "gyro_3d", 3);
        kernel.add_axes(kGyro, "in_anglvel", 0, "le:s32/32>>0", "0.000001");
        kernel.file(kGyro, "in_anglvel_hysteresis") = "0.5";
        kernel.add_device(kAccel, "accel_3d", 3);
        kernel.add_axes(kAccel, "in_accel", 0, "le:s32/32>>0", "0.001");
        kernel.file(kAccel, "in_accel_hysteresis") = "0.1";
    }

    void rate(std::int64_t stamp_ns, int x = 1'000'000) {
        kernel.push(kGyro, test::ScanBytes().add({x, 0, 0}, 4).add(stamp_ns, 8));
    }
    void force(std::int64_t stamp_ns, int z = 9810) {
        kernel.push(kAccel, test::ScanBytes().add({0, 0, z}, 4).add(stamp_ns, 8));
    }
    ImuSource& source() override { return imu; }
    void offer(int count) override {
        for (int i = 0; i < count; ++i) {
            clock.advance({kPeriodNs});
            rate(clock.now().ns - 1'000'000);
            force(clock.now().ns);
        }
    }
    test::Hook offer_corrupt() override {
        kernel.push(kAccel, {1, 2, 3, 4, 5});
        return test::Hook::kDone;
    }
    test::Hook offer_ahead() override {
        rate(clock.now().ns + kHourNs);
        force(clock.now().ns + kHourNs + 1'000'000);
        return test::Hook::kDone;
    }
    test::Hook break_device() override {
        kernel.unplug(kAccel);
        return test::Hook::kDone;
    }
    void repair_device() override { kernel.plug(kAccel); }
    test::Hook judges_silence() override { return test::Hook::kDone; }
    test::Hook end() override { return test::Hook::kCannot; }
    void pass_time() override { clock.advance(Duration::from_seconds(0.6)); }
    int held_back() const override { return 1; }  // the first rate has no force before it

    ManualClock clock{{20'000'000'000}, {kEpochNs}};
    test::FakeIio kernel{clock};
    ImuIio imu;
};

TEST_CASE("one device and two keep the contract of the port", "[port_conformance]") {
    test::check_source_conformance<test::ImuHarness>([] { return std::make_unique<OneDevice>(); });
    test::check_source_conformance<test::ImuHarness>([] { return std::make_unique<TwoDevices>(); });
}

TEST_CASE("scans become samples by scale, offset, mount matrix and axes") {
    ImuIioOptions options = options_of("imu", "imu");
    REQUIRE(ok(options.axes.parse("x -y -z")));
    options.latency = {2'000'000};
    OneDevice h(options);
    h.kernel.file(kGyro, "in_anglvel_offset") = "-100";
    h.kernel.file(kGyro, "in_accel_z_scale") = "0.02";
    h.kernel.file(kGyro, "in_accel_z_offset") = "10";
    h.kernel.file(kGyro, "in_mount_matrix") = "0, 1, 0; -1, 0, 0; 0, 0, 1";
    h.kernel.file(kGyro, "in_accel_mount_matrix") = "1.0, 0.0, 0.0; 0.0, 1.0, 0.0; 0.0, 0.0, 1.0";
    REQUIRE(ok(h.imu.start()));
    h.offer(1);
    ImuSample sample;
    REQUIRE(h.imu.next({}, sample) == Status::kOk);
    CHECK(sample.stamp.ns == h.clock.now().ns - 2'000'000);
    // Raw 1000, 0, -500, less 100, in mrad/s: 0.9, -0.1, -0.6; mounted: -0.1, -0.9, -0.6; then the axes.
    CHECK((sample.w_B - Eigen::Vector3d(-0.1, 0.9, 0.6)).norm() < 1e-12);
    CHECK((sample.a_B - Eigen::Vector3d(0.0, 0.0, -19.82)).norm() < 1e-12);
    CHECK(h.imu.clock() == ClockDomain::kMonotonic);
    CHECK(h.kernel.file(kGyro, "current_timestamp_clock") == "monotonic");
    h.imu.stop();
    CHECK(h.kernel.file(kGyro, "buffer/enable") == "0");
    CHECK(h.kernel.open_nodes == 0);
}

TEST_CASE("forces of another device are interpolated, and its scans are waited for") {
    TwoDevices h;
    REQUIRE(ok(h.imu.start()));
    CHECK(h.kernel.file(kGyro, "in_anglvel_hysteresis") == "0");
    CHECK(h.kernel.file(kAccel, "in_accel_hysteresis") == "0");
    h.clock.advance({100'000'000});
    const std::int64_t now = h.clock.now().ns;
    h.force(now - 30'000'000, 9000);
    h.rate(now - 25'000'000);
    h.force(now - 20'000'000, 10'000);
    h.force(now - 10'000'000, 11'000);
    h.rate(now - 15'000'000);
    ImuSample sample;
    REQUIRE(h.imu.next({}, sample) == Status::kOk);
    CHECK(sample.stamp.ns == now - 25'000'000);
    CHECK(std::abs(sample.a_B.z() - 9.5) < 1e-9);
    CHECK(std::abs(sample.w_B.x() - 1.0) < 1e-9);
    REQUIRE(h.imu.next({}, sample) == Status::kOk);
    CHECK(std::abs(sample.a_B.z() - 10.5) < 1e-9);
    h.rate(now - 5'000'000);
    CHECK(h.imu.next(Duration::from_seconds(0.02), sample) == Status::kNotReady);
    CHECK(h.clock.now().ns == now + 20'000'000);
}

TEST_CASE("what others left enabled is disabled, and what is read is enabled") {
    OneDevice h;
    h.kernel.add_element(kGyro, "in_magn_x", 7, "le:s16/16>>0");
    h.kernel.file(kGyro, "scan_elements/in_magn_x_en") = "1";
    h.kernel.add_element(kGyro, "in_temp0", 8, "le:s16/16>>0");
    h.kernel.file(kGyro, "in_temp_scale") = "10";
    h.kernel.file(kGyro, "in_temp_offset") = "5";
    REQUIRE(ok(h.imu.start()));
    CHECK(h.kernel.file(kGyro, "scan_elements/in_magn_x_en") == "0");
    CHECK(h.kernel.file(kGyro, "scan_elements/in_accel_y_en") == "1");
    CHECK(h.kernel.file(kGyro, "buffer/length") == "128");
    CHECK(std::isnan(h.imu.temperature_c()));
    h.clock.advance({kPeriodNs});
    // The stamp is not the last element, and the scan is padded to eight bytes.
    h.kernel.push(kGyro, test::ScanBytes()
                             .add({1000, 0, 0}, 2, true)
                             .add({0, 0, 981}, 2)
                             .add(h.clock.now().ns, 8)
                             .add(2495, 2)
                             .add(0, 8));
    CHECK(test::drain(h).stamps.size() == 1);
    CHECK(std::abs(h.imu.temperature_c() - 25.0) < 1e-9);
}

TEST_CASE("stamps: the wall clock is mapped, and steps of it cost the scans that waited") {
    ImuIioOptions options = options_of("imu", "imu");
    OneDevice old(options);
    old.kernel.remove(kGyro, "current_timestamp_clock");  // the kernel has no choice
    REQUIRE(ok(old.imu.start()));
    old.clock.advance({kPeriodNs});
    old.kernel.push(kGyro, old.scan(old.clock.read_pair().realtime.ns));
    CHECK(test::drain(old).stamps == std::vector<Timestamp>{old.clock.now()});
    old.clock.advance({kPeriodNs});
    old.kernel.push(kGyro, old.scan(old.clock.read_pair().realtime.ns));
    old.clock.set_realtime_offset({kEpochNs - kHourNs});
    CHECK(test::drain(old).stamps.empty());
    CHECK(old.imu.stamps_refused() == 1);
    old.clock.advance({kPeriodNs});
    old.kernel.push(kGyro, old.scan(old.clock.read_pair().realtime.ns));
    CHECK(test::drain(old).stamps.size() == 1);

    options.device.clock = IioClock::kRealtime;
    OneDevice asked(options);
    REQUIRE(ok(asked.imu.start()));
    CHECK(asked.kernel.file(kGyro, "current_timestamp_clock") == "realtime");
    asked.clock.advance({kPeriodNs});
    asked.kernel.push(kGyro, asked.scan(asked.clock.read_pair().realtime.ns));
    CHECK(test::drain(asked).stamps == std::vector<Timestamp>{asked.clock.now()});
}

TEST_CASE("stamps that stand or go back are discarded, and zeros are of long ago") {
    OneDevice h;
    REQUIRE(ok(h.imu.start()));
    h.offer(3);
    const std::int64_t last = h.clock.now().ns;
    for (const std::int64_t stamp_ns : {last, last - kPeriodNs, std::int64_t{0}}) {
        h.kernel.push(kGyro, h.scan(stamp_ns));
    }
    h.offer(2);
    CHECK(test::drain(h).stamps.size() == 5);
    CHECK(h.imu.counters().discarded == 2 * 2 + 1);  // of two a rate and a force each, and a scan
    CHECK(h.imu.stamps_refused() == 1);
    CHECK(h.imu.problem().empty());
}

TEST_CASE("devices without stamps are for the bench, when asked for") {
    ImuIioOptions options = options_of("imu", "imu");
    options.stamps = IioStamps::kArrival;
    OneDevice h(options);
    REQUIRE(ok(h.imu.start()));
    CHECK(h.kernel.file(kGyro, "scan_elements/in_timestamp_en") == "0");
    CHECK(h.imu.warning() == "stamps are those of the reading: for the bench only");
    h.clock.advance({kPeriodNs});
    h.kernel.push(kGyro, test::ScanBytes().add({1, 0, 0}, 2, true).add({0, 0, 981}, 2));
    CHECK(test::drain(h).stamps == std::vector<Timestamp>{h.clock.now()});

    OneDevice refused;
    for (const char* suffix : {"_en", "_index", "_type"}) {
        refused.kernel.remove(kGyro, std::string("scan_elements/in_timestamp") + suffix);
    }
    CHECK(refused.imu.start() == Status::kInvalidArgument);
    CHECK(refused.imu.problem() == "imu: has no time stamps in its scans; imu.iio.stamps: arrival is for the bench");
}

TEST_CASE("rates: the device's, a list's, each quantity's, or the trigger's") {
    ImuIioOptions options = options_of("imu", "imu");
    options.device.rate_hz = 200.0;
    OneDevice plain(options);
    plain.kernel.file(kGyro, "sampling_frequency") = "100";
    REQUIRE(ok(plain.imu.start()));
    CHECK(plain.kernel.file(kGyro, "sampling_frequency") == "200");
    CHECK(plain.imu.warning().empty());

    OneDevice listed(options);
    listed.kernel.file(kGyro, "in_accel_sampling_frequency") = "12.5";
    listed.kernel.file(kGyro, "in_anglvel_sampling_frequency") = "12.5";
    listed.kernel.file(kGyro, "in_anglvel_sampling_frequency_available") = "12.500 26 52 104 208 416";
    listed.kernel.file(kGyro, "in_accel_sampling_frequency_available") = "[1 1 1000]";
    REQUIRE(ok(listed.imu.start()));
    CHECK(listed.kernel.file(kGyro, "in_anglvel_sampling_frequency") == "208");
    CHECK(listed.kernel.file(kGyro, "in_accel_sampling_frequency") == "200");
    CHECK(listed.imu.warning() == "imu samples at 208 Hz instead of 200");

    options.device.trigger = "timer";
    OneDevice timed(options);
    timed.kernel.file(kGyro, "trigger/current_trigger") = "";
    timed.kernel.file("trigger0", "name") = "other";
    timed.kernel.file("trigger4", "name") = "timer";
    timed.kernel.file("trigger4", "sampling_frequency") = "100.000";
    REQUIRE(ok(timed.imu.start()));
    CHECK(timed.kernel.file(kGyro, "trigger/current_trigger") == "timer");
    CHECK(timed.kernel.file("trigger4", "sampling_frequency") == "200");
}

TEST_CASE("triggers: a device's own is found, and one that does not exist is named") {
    OneDevice own;
    own.kernel.file(kGyro, "trigger/current_trigger") = "";
    REQUIRE(ok(own.imu.start()));
    CHECK(own.kernel.file(kGyro, "trigger/current_trigger") == "imu-dev3");

    ImuIioOptions options = options_of("imu", "imu");
    options.device.trigger = "timer";
    OneDevice missing(options);
    missing.kernel.file(kGyro, "trigger/current_trigger") = "imu-dev3";
    missing.kernel.on_write = [](const std::string& path, std::string& value) {
        value = path.find("current_trigger") != std::string::npos ? "" : value;
    };
    CHECK(missing.imu.start() == Status::kInvalidArgument);
    CHECK(missing.imu.problem() == "imu: trigger 'timer' does not exist, or is not for this device");

    OneDevice none;
    none.kernel.file(kGyro, "trigger/current_trigger") = "";
    none.kernel.on_write = [&](const std::string& path, std::string& value) {
        value = path.find("current_trigger") != std::string::npos ? "" : value;
        if (path.find("buffer/length") != std::string::npos) {
            none.kernel.refusals["buffer/enable"] = -EINVAL;
        }
    };
    CHECK(none.imu.start() == Status::kIo);
    CHECK(none.imu.problem() == "imu: the buffer does not start without a trigger: imu.iio.trigger: Invalid argument");
}

TEST_CASE("settings are written to the devices that have them, and must be somebody's") {
    ImuIioOptions options = options_of("gyro_3d", "accel_3d");
    options.device.settings = {{"in_accel_scale", "0.002"}, {"in_anglvel_scale", "0.000002"}};
    TwoDevices h(options);
    REQUIRE(ok(h.imu.start()));
    CHECK(h.kernel.file(kAccel, "in_accel_scale") == "0.002");
    CHECK(h.kernel.file(kGyro, "in_anglvel_scale") == "0.000002");
    h.offer(2);
    ImuSample sample;
    REQUIRE(h.imu.next({}, sample) == Status::kOk);
    CHECK(std::abs(sample.w_B.x() - 2.0) < 1e-9);

    options.device.settings = {{"in_acel_scale", "1"}};
    TwoDevices missing(options);
    CHECK(missing.imu.start() == Status::kInvalidArgument);
    CHECK(missing.imu.problem() == "gyro_3d: no attribute 'in_acel_scale' to set");
    options.device.settings = {{"in_accel_scale", "7"}};
    TwoDevices refused(options);
    refused.kernel.refusals["in_accel_scale"] = -EINVAL;
    CHECK(refused.imu.start() == Status::kIo);
    CHECK(refused.imu.problem() == "accel_3d: in_accel_scale does not take '7': Invalid argument");
}

/// What start() says of a device that `change` has been done to.
std::string problem_with(const std::function<void(test::FakeIio&)>& change, Status expected) {
    OneDevice h;
    change(h.kernel);
    CHECK(h.imu.start() == expected);
    CHECK(h.kernel.open_nodes == 0);
    return std::string(h.imu.problem());
}

TEST_CASE("what a device lacks, or the system refuses, is said in words") {
    CHECK(problem_with([](auto& k) { k.file(kGyro, "name") = "other"; }, Status::kNotFound) ==
          "imu: no such device in /sys/bus/iio/devices; there are: other");
    CHECK(problem_with([](auto& k) { k.unplug(kGyro); }, Status::kNotFound) ==
          "imu: no such device in /sys/bus/iio/devices, which has none");
    CHECK(problem_with([](auto& k) { k.refusals["/dev/iio:device3"] = -EBUSY; }, Status::kIo) ==
          "imu: /dev/iio:device3 cannot be opened: Device or resource busy");
    CHECK(problem_with([](auto& k) { k.refusals["buffer/enable"] = -EACCES; }, Status::kIo) ==
          "imu: buffer/enable cannot be set: Permission denied; the program's user must be allowed to write the "
          "attributes");
    CHECK(problem_with([](auto& k) { k.remove(kGyro, "buffer/enable"); }, Status::kInvalidArgument) ==
          "imu: has no buffer: its driver gives single readings only");
    CHECK(problem_with([](auto& k) { k.remove(kGyro, "in_anglvel_scale"); }, Status::kIo) ==
          "imu: in_anglvel_scale cannot be read: No such file or directory");
    CHECK(problem_with([](auto& k) { k.file(kGyro, "in_accel_scale") = "0.0"; }, Status::kInvalidArgument) ==
          "imu: in_accel_scale is zero");
    CHECK(problem_with([](auto& k) { k.remove(kGyro, "scan_elements/in_accel_y_en"); }, Status::kInvalidArgument) ==
          "imu: has no accelerations (in_accel_x to z) in its scans");
    CHECK(problem_with([](auto& k) { k.remove(kGyro, "scan_elements/in_accel_y_index"); }, Status::kIo) ==
          "imu: scan_elements/in_accel_y has no index or no type: No such file or directory");
    CHECK(problem_with([](auto& k) { k.file(kGyro, "scan_elements/in_accel_x_type") = "le:f32/32>>0"; },
                       Status::kInvalidArgument) ==
          "imu: scan_elements/in_accel_x_type is 'le:f32/32>>0', a form that is not known");
    CHECK(problem_with([](auto& k) { k.file(kGyro, "scan_elements/in_accel_x_index") = "4"; },
                       Status::kInvalidArgument) ==
          "imu: its scan elements have equal indices, or are too large together");
    CHECK(problem_with([](auto& k) { k.file(kGyro, "mount_matrix") = "1, 0, 0; 0, 1, 0; 0, 0, -1"; },
                       Status::kInvalidArgument) ==
          "imu: mount_matrix is '1, 0, 0; 0, 1, 0; 0, 0, -1', no rotation; imu.iio.mount_matrix: false leaves it out");
    CHECK(problem_with([](auto& k) { k.file(kGyro, "mount_matrix") = "1, 0, 0; 0, 1"; }, Status::kInvalidArgument)
              .find("no rotation") != std::string::npos);
}

TEST_CASE("a device that is plugged in again under another number is found by its name") {
    TwoDevices h;
    REQUIRE(ok(h.imu.start()));
    h.offer(3);
    (void)test::drain(h);
    h.kernel.unplug(kGyro);
    ImuSample sample;
    CHECK(h.imu.next({}, sample) == Status::kIo);
    CHECK(h.imu.problem() == "gyro_3d: No such device");
    h.kernel.add_device("iio:device7", "gyro_3d", 3);
    h.kernel.add_axes("iio:device7", "in_anglvel", 0, "le:s16/16>>0", "0.001");
    h.pass_time();
    CHECK(h.imu.next({}, sample) == Status::kNotReady);
    for (int i = 0; i < 3; ++i) {
        h.clock.advance({kPeriodNs});
        h.kernel.push("iio:device7", test::ScanBytes().add({500, 0, 0}, 2).add(h.clock.now().ns - 1'000'000, 8));
        h.force(h.clock.now().ns);
    }
    CHECK(test::drain(h).stamps.size() == 2);
    CHECK(h.imu.counters().recoveries == 1);
}

TEST_CASE("a folder and a pipe stand in for the kernel's, and neither reading nor reopening takes heap") {
    const test::TempDir dir;
    const std::filesystem::path folder = dir.file("sys/iio:device0");
    const auto write = [&](const std::string& name, const std::string& text) {
        std::filesystem::create_directories((folder / name).parent_path());
        std::ofstream(folder / name) << text << "\n";
    };
    const auto read = [&](const std::string& name) {
        std::string text;
        std::ifstream(folder / name) >> text;
        return text;
    };
    write("name", "imu");
    write("in_anglvel_scale", "0.001");
    write("in_accel_scale", "0.01");
    write("buffer/enable", "0");
    write("buffer/length", "2");
    write("current_timestamp_clock", "realtime");
    int index = 0;
    for (const char* element : {"anglvel_x", "anglvel_y", "anglvel_z", "accel_x", "accel_y", "accel_z", "timestamp"}) {
        const std::string name = std::string("scan_elements/in_") + element;
        write(name + "_en", "0");
        write(name + "_index", std::to_string(index++));
        write(name + "_type", index == 7 ? "le:s64/64>>0" : "le:s16/16>>0");
    }
    std::filesystem::create_directories(dir.file("dev"));
    const std::string node = dir.file("dev/iio:device0");
    REQUIRE(::mkfifo(node.c_str(), 0600) == 0);
    const int pipe = ::open(node.c_str(), O_RDWR | O_CLOEXEC);
    REQUIRE(pipe >= 0);

    LinuxKernelIo io;
    LinuxClock clock;
    ImuIioOptions options = options_of("imu", "imu");
    options.device.sysfs = dir.file("sys");
    options.device.dev = dir.file("dev");
    ImuIio imu(io, clock, options);
    REQUIRE(ok(imu.start()));
    CHECK(read("buffer/enable").substr(0, 1) == "1");
    CHECK(read("scan_elements/in_timestamp_en").substr(0, 1) == "1");
    for (int i = 0; i < 100; ++i) {
        const std::vector<std::uint8_t> scan =
            test::ScanBytes().add({i, 0, 0}, 2).add({0, 0, 981}, 2).add(clock.now().ns, 8);
        REQUIRE(::write(pipe, scan.data(), scan.size()) == static_cast<ssize_t>(scan.size()));
    }
    for (int i = 0; i < 100; ++i) {
        ImuSample sample;
        const test::AllocationGuard guard;
        const Status status = imu.next(Duration::from_seconds(1.0), sample);
        const std::uint64_t allocations = guard.allocations();
        REQUIRE(status == Status::kOk);
        CHECK(allocations == 0);
        CHECK(std::abs(sample.w_B.x() - 0.001 * i) < 1e-12);
        CHECK(std::abs(sample.a_B.z() - 9.81) < 1e-12);
    }
    ImuSample sample;
    CHECK(imu.next({}, sample) == Status::kNotReady);
    imu.stop();
    const test::AllocationGuard guard;
    const Status again = imu.start();
    const std::uint64_t allocations = guard.allocations();
    CHECK(ok(again));
    CHECK(allocations == 0);
    imu.stop();
    CHECK(read("buffer/enable").substr(0, 1) == "0");
    (void)::close(pipe);
}

}  // namespace
}  // namespace facet::imu_iio_test
