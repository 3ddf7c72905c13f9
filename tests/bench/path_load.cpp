// SPDX-License-Identifier: BSD-2-Clause
// What each way of samples into the program costs: the drivers themselves on scripted devices, and the processor time
// of the thread that asks them, as a line of JSON for each. For a table: scripts/benchmark paths. The scripted device's
// own work (registers, copies into the kernel's buffers) is in the figure, a kernel's is not. A Catch2 program, because
// the devices check what they are asked.
#include <time.h>

#include <catch2/catch.hpp>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>
#include <vector>

#include "drivers/imu_iio/imu_iio.h"
#include "drivers/imu_serial/imu_serial.h"
#include "drivers/imu_spi/imu_spi.h"
#include "drivers/ros2/camera_ros2.h"
#include "drivers/ros2/imu_ros2.h"
#include "tests/drivers/camera_v4l2/camera_harness.h"
#include "tests/drivers/imu_iio/fake_iio.h"
#include "tests/drivers/imu_serial/serial_packets.h"
#include "tests/drivers/imu_spi/fake_adis.h"
#include "tests/drivers/mavlink/fake_autopilot.h"
#include "tests/drivers/ros2/fake_ros2.h"
#include "tests/support/jpeg_images.h"

namespace facet {
namespace {

constexpr int kSamples = 20'000;
constexpr int kImages = 400;
constexpr int kWarmUp = 50;
constexpr Duration kImuPeriod{5'000'000};
constexpr Duration kImagePeriod{50'000'000};
constexpr std::uint32_t kWidth = 752;
constexpr std::uint32_t kHeight = 480;

double processor_us() {
    timespec time{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) * 1e6 + static_cast<double>(time.tv_nsec) * 1e-3;
}

/// Offers one sample at a time and takes all that the source then has. @return processor time of a sample taken (us)
template <class Sample, class Source>
double cost_us(Source& source, int count, const std::function<void()>& offer) {
    double sum_us = 0.0;
    int taken = 0;
    for (int i = 0; i < count + kWarmUp; ++i) {
        offer();
        const double begin_us = processor_us();
        Sample sample;
        int here = 0;
        while (ok(source.next({}, sample))) {
            ++here;
            sample = {};
        }
        const double end_us = processor_us();
        if (i >= kWarmUp) {
            sum_us += end_us - begin_us;
            taken += here;
        }
    }
    REQUIRE(taken > count * 9 / 10);
    return sum_us / taken;
}

/// @param bytes  of a sample on a serial line, start and stop bits apart; 0: it is on none
void print(const char* kind, const char* path, const char* stand_in, double cost, int bytes = 0) {
    std::cout << nlohmann::ordered_json{{"kind", kind},
                                        {"path", path},
                                        {"stand_in", stand_in},
                                        {"us", cost},
                                        {"bytes", bytes}}
                     .dump()
              << "\n";
}

void measure_spi() {
    ManualClock clock{{1'000'000'000}};
    test::LazyEdges edges{clock};
    test::FakeAdis device(Adis16Model::k16448);
    Adis16 chip(device, clock, {Adis16Model::k16448, 4, true});
    ImuSpi imu(chip, &edges, clock, {});
    edges.on_edge = [&](Timestamp) { device.sample(100); };
    REQUIRE(ok(imu.start()));
    print("imu", "SPI (ADIS16448)", "register file, edges of a line",
          cost_us<ImuSample>(imu, kSamples, [&] { ++edges.waiting; }));
}

void measure_mavlink() {
    MavlinkOptions link;
    link.channel.serial = "/dev/ttyS1";
    test::AutopilotScene scene({}, link);
    REQUIRE(ok(scene.imu.start()));
    scene.learn_time();
    const double cost = cost_us<ImuSample>(scene.imu, kSamples, [&] { scene.tick(kImuPeriod); });
    constexpr int kHighresBytes = 63 + 12;
    print("imu", "MAVLink (HIGHRES_IMU)", "autopilot at a serial line", cost, kHighresBytes);
}

void measure_iio() {
    constexpr const char* kDevice = "iio:device3";
    ManualClock clock{{1'000'000'000}};
    test::FakeIio kernel(clock);
    kernel.add_device(kDevice, "imu", 6);
    kernel.add_axes(kDevice, "in_anglvel", 0, "be:s16/16>>0", "0.001");
    kernel.add_axes(kDevice, "in_accel", 3, "le:s16/16>>0", "0.01");
    ImuIioOptions options;
    options.gyro = options.accel = "imu";
    ImuIio imu(kernel, clock, options);
    REQUIRE(ok(imu.start()));
    print("imu", "IIO", "files and nodes of a device", cost_us<ImuSample>(imu, kSamples, [&] {
              clock.advance(kImuPeriod);
              kernel.push(kDevice,
                          test::ScanBytes().add({1000, 0, -500}, 2, true).add({0, 0, 981}, 2).add(clock.now().ns, 8));
          }));
}

void measure_serial(SerialSensor sensor, const char* path) {
    ManualClock clock{{1'000'000'000}};
    test::FakeSerial line(clock);
    ImuSerialOptions options;
    options.sensor = sensor;
    ImuSerial imu(line, clock, options);
    REQUIRE(ok(imu.start()));
    test::SerialSample sample;
    const double cost = cost_us<ImuSample>(imu, kSamples, [&] {
        clock.advance(kImuPeriod);
        sample.time_ns += kImuPeriod.ns;
        ++sample.count;
        line.arrive(test::packet_of(sensor, sample));
    });
    print("imu", path, "packets on a line", cost, static_cast<int>(test::packet_of(sensor, sample).size()));
}

void measure_ros2_imu() {
    ManualClock clock{{1'000'000'000}, Duration::from_seconds(1.7e9)};
    test::FakeNode node;
    ImuRos2Options options;
    options.topic = "/imu";
    ImuRos2 imu(node, clock, options);
    REQUIRE(ok(imu.start()));
    print("imu", "ROS 2", "messages behind the middleware", cost_us<ImuSample>(imu, kSamples, [&] {
              clock.advance(kImuPeriod);
              node.graph.samples.push_back({clock.read_pair().realtime, {0.1, 0.2, 0.3}, {1.0, 2.0, 9.8}});
          }));
}

void measure_camera(const char* path, std::uint32_t format, std::uint32_t bytes_a_pixel,
                    const std::vector<std::uint8_t>& content = {}) {
    ManualClock clock{{1'000'000'000}};
    test::FakeCamera kernel(clock);
    kernel.width = kWidth;
    kernel.height = kHeight;
    kernel.stride = kWidth * bytes_a_pixel;
    kernel.format = format;
    kernel.modes = {{format, kWidth, kWidth * bytes_a_pixel, 60.0}};
    CameraV4l2Options options;
    options.capture.width = kWidth;
    options.capture.height = kHeight;
    options.capture.any_format = true;
    CameraV4l2 camera(kernel, clock, options);
    REQUIRE(ok(camera.start()));
    std::int64_t stamp_ns = 2'000'000'000;
    print("image", path, "buffers of a node", cost_us<CameraFrame>(camera, kImages, [&] {
              stamp_ns += kImagePeriod.ns;
              if (content.empty()) {
                  kernel.expose(100, stamp_ns);
              } else {
                  kernel.expose_bytes(content, stamp_ns);
              }
          }));
}

void measure_ros2_camera() {
    ManualClock clock{{1'000'000'000}, Duration::from_seconds(1.7e9)};
    test::FakeNode node;
    CameraRos2Options options;
    options.topic = "/left";
    options.width = kWidth;
    options.height = kHeight;
    CameraRos2 camera(node, clock, options);
    REQUIRE(ok(camera.start()));
    print("image", "ROS 2, mono8", "messages behind the middleware", cost_us<CameraFrame>(camera, kImages, [&] {
              clock.advance(kImagePeriod);
              test::FakeImage image;
              image.image.stamp = clock.read_pair().realtime;
              image.image.width = kWidth;
              image.image.height = kHeight;
              image.image.step = kWidth;
              image.data.assign(std::size_t{kWidth} * kHeight, 100);
              node.graph.images.push_back(std::move(image));
          }));
}

}  // namespace

TEST_CASE("what each path costs", "[.figures]") {
    measure_spi();
    measure_mavlink();
    measure_iio();
    measure_serial(SerialSensor::kVectorNav, "serial (VectorNav)");
    measure_serial(SerialSensor::kXsens, "serial (Xsens)");
    measure_serial(SerialSensor::kMicroStrain, "serial (MicroStrain)");
    measure_ros2_imu();
    measure_camera("V4L2, GREY (CSI)", V4L2_PIX_FMT_GREY, 1);
    measure_camera("V4L2, YUYV (UVC)", V4L2_PIX_FMT_YUYV, 2);
    measure_camera("V4L2, MJPG (UVC)", V4L2_PIX_FMT_MJPEG, 2, test::jpeg_of(kWidth, kHeight, {}));
    measure_ros2_camera();
}

}  // namespace facet
