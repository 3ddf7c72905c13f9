// SPDX-License-Identifier: BSD-2-Clause
#include "tests/hil/inject/imu_encoding.h"

#include <catch2/catch.hpp>
#include <numbers>

#include "drivers/imu_spi/adis16.h"
#include "platform/base/angle.h"
#include "tests/hil/inject/fault_plan.h"

namespace facet::hil::imu_encoding_test {
namespace {

constexpr Duration kInterval{5'000'000};

ImuSample sample() {
    ImuSample s;
    s.stamp = {1'700'000'000'000'000'000};
    s.w_B = {0.123456789, -1.987654321, 3.0 / 7.0};
    s.a_B = {9.80665, -0.0123456, -11.1111111};
    return s;
}

ImuSample encoded(ImuKind kind, const ImuSample& one) { return as_encoded(kind, {one}, kInterval).front(); }

/// Largest difference that rounding to steps of this size can make, a little more for the arithmetic.
void require_within_half(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double step) {
    REQUIRE((a - b).cwiseAbs().maxCoeff() <= 0.5 * step * (1.0 + 1e-6));
}

TEST_CASE("What a sensor sends is the sample to its own resolution") {
    struct Resolution {
        ImuKind kind;
        double rate;
        double force;
    };
    const double deg = std::numbers::pi / 180.0;
    for (const Resolution& r :
         {Resolution{ImuKind::kIcm42688, 2000.0 * deg / 524288.0, 16.0 * 9.80665 / 524288.0},
          Resolution{ImuKind::kAdis16475, deg / 40.0, 9.80665 / 4000.0}, Resolution{ImuKind::kDroneCan, 1e-6, 2e-6},
          Resolution{ImuKind::kOpenImu300, deg / 128.0, 0.01}, Resolution{ImuKind::kIio, 0.000066579, 0.004788403}}) {
        CAPTURE(static_cast<int>(r.kind));
        const ImuSample back = encoded(r.kind, sample());
        require_within_half(back.w_B, sample().w_B, r.rate);
        require_within_half(back.a_B, sample().a_B, r.force);
        REQUIRE(back.stamp == sample().stamp);
        // Rounding what is round already changes nothing; only integrals in single precision are rounded again.
        const ImuSample again = encoded(r.kind, back);
        REQUIRE((again.a_B - back.a_B).norm() <= (r.kind == ImuKind::kDroneCan ? 1e-5 : 1e-12));
    }
}

TEST_CASE("Values beyond a sensor's range are clipped") {
    ImuSample strong = sample();
    strong.a_B = {1000.0, -1000.0, 0.0};
    const ImuSample back = encoded(ImuKind::kAdis16475, strong);
    REQUIRE(back.a_B.x() < 81.0);
    REQUIRE(back.a_B.x() > 80.0);
    REQUIRE(back.a_B.y() == -back.a_B.x());
    REQUIRE(encoded(ImuKind::kIcm42688, strong).a_B.x() < 16.0 * 9.80665);
    REQUIRE(encoded(ImuKind::kIio, strong).a_B.x() < 16.0 * 9.80665);
}

TEST_CASE("The burst of the ADIS16475 has the sum that its driver expects") {
    const auto burst = adis_burst(sample(), 4711);
    std::array<std::uint16_t, 10> words{};
    for (std::size_t i = 0; i < words.size(); ++i) {
        words[i] = static_cast<std::uint16_t>((burst[2 * i] << 8) | burst[2 * i + 1]);
    }
    REQUIRE(words[8] == 4711);
    REQUIRE(adis1647x_checksum(std::span(words).first(9)) == words[9]);
}

TEST_CASE("A plan of faults is read, and distinguished from nonsense") {
    FaultPlan plan;
    plan.add("imu_silent@5+0.3");
    plan.add("torn@1+2");
    REQUIRE(plan.active(FaultKind::kImuSilent, Duration::from_seconds(5.0)));
    REQUIRE_FALSE(plan.active(FaultKind::kImuSilent, Duration::from_seconds(5.3)));
    REQUIRE_FALSE(plan.active(FaultKind::kTorn, Duration::from_seconds(0.99)));
    REQUIRE(plan.active(FaultKind::kTorn, Duration::from_seconds(1.0)));
    for (const char* wrong : {"", "imu_silent", "imu_silent@5", "nothing@1+1", "torn@x+1", "torn@1+-1", "torn+1@2"}) {
        CAPTURE(wrong);
        REQUIRE_THROWS(plan.add(wrong));
    }
}

}  // namespace
}  // namespace facet::hil::imu_encoding_test
