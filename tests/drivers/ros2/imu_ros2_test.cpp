// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/ros2/imu_ros2.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "tests/drivers/ros2/fake_ros2.h"
#include "tests/port_conformance/source_conformance.h"
#include "tests/support/scripted_source.h"

namespace facet::imu_ros2_test {
namespace {

constexpr Duration kImuPeriod = Duration::from_seconds(0.005);

ImuRos2Options imu_options() {
    ImuRos2Options options;
    options.topic = "/imu";
    options.silence = Duration::from_seconds(1.0);
    return options;
}

class ImuRos2Harness final : public test::ImuHarness {
public:
    explicit ImuRos2Harness(const ImuRos2Options& options = imu_options()) : imu(node, clock, options) {}

    ImuSource& source() override { return imu; }
    void offer(int count) override {
        for (int i = 0; i < count; ++i) {
            clock.advance(kImuPeriod);
            node.graph.samples.push_back({clock.read_pair().realtime, {0.1, 0.2, 0.3}, {1.0, 2.0, 9.8}});
        }
    }
    test::Hook offer_corrupt() override {
        offer(1);
        node.graph.samples.back().a.y() = std::nan("");
        return test::Hook::kDone;
    }
    test::Hook offer_ahead() override {
        offer(1);
        node.graph.samples.back().stamp = clock.read_pair().realtime + Duration::from_seconds(3600.0);
        return test::Hook::kDone;
    }
    test::Hook break_device() override {
        node.graph.is_broken = true;
        return test::Hook::kDone;
    }
    void repair_device() override { node.graph.is_broken = false; }
    test::Hook judges_silence() override { return test::Hook::kDone; }
    test::Hook end() override { return test::Hook::kCannot; }
    void pass_time() override { clock.advance(Duration::from_seconds(0.6)); }
    int held_back() const override { return 0; }

    ManualClock clock{{1'000'000'000}, Duration::from_seconds(1.7e9)};
    test::FakeNode node;
    ImuRos2 imu;
};

TEST_CASE("an inertial sensor on a topic keeps the contract of sources") {
    test::check_source_conformance<test::ImuHarness>([] { return std::make_unique<ImuRos2Harness>(); });
}

TEST_CASE("samples are turned into the body, at the instant that was measured") {
    ImuRos2Options options = imu_options();
    options.latency = Duration::from_seconds(0.002);
    REQUIRE(ok(options.axes.parse("z -x -y")));  // an optical frame
    ImuRos2Harness h(options);
    REQUIRE(ok(h.imu.start()));
    h.offer(1);
    ImuSample sample;
    REQUIRE(ok(h.imu.next({}, sample)));
    CHECK(sample.stamp == h.clock.read_pair().realtime - options.latency);
    CHECK(sample.w_B == Eigen::Vector3d(0.3, -0.1, -0.2));
    CHECK(sample.a_B == Eigen::Vector3d(9.8, -1.0, -2.0));
}

TEST_CASE("rates and forces that come apart are refused in words") {
    ImuRos2Harness h;
    REQUIRE(ok(h.imu.start()));
    h.offer(2);
    h.node.graph.samples[0].has_forces = false;
    h.node.graph.samples[1].has_rates = false;
    CHECK(test::drain(static_cast<test::ImuHarness&>(h)).corrupt == 2);
    CHECK(std::string(h.imu.problem()).find("unite") != std::string::npos);
    h.offer(3);
    h.node.graph.samples[0].a.x() = 1e6;
    h.node.graph.samples[1].w.z() = std::numeric_limits<double>::infinity();
    CHECK(test::drain(static_cast<test::ImuHarness&>(h)).corrupt == 2);
    CHECK(h.imu.counters().corrupt == 4);
}

}  // namespace
}  // namespace facet::imu_ros2_test
