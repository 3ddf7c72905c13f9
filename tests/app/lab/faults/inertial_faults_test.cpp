// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/faults/inertial_faults.h"

#include <catch2/catch.hpp>
#include <cmath>

namespace facet::inertial_faults_test {
namespace {

constexpr std::int64_t kBegin = 1'000'000'000'000;
constexpr std::int64_t kStep = 5'000'000;
const Eigen::Vector3d kAxes(0.1, 0.2, 0.3);

/// Readings of 10 s at 200 Hz that tell their number: w = number * kAxes, a = -w.
std::vector<ImuSample> readings(const std::string& spec) {
    FaultSchedule schedule({parse_fault(spec)}, {kBegin});
    InertialFaults faults(schedule, ImuNoise{});
    std::vector<ImuSample> samples;
    for (int i = 0; i < 2000; ++i) {
        ImuSample sample{.stamp = {kBegin + i * kStep}, .w_B = i * kAxes, .a_B = -i * kAxes};
        faults.change(sample, static_cast<std::uint64_t>(i) + 1);
        samples.push_back(sample);
    }
    return samples;
}

bool is_as_recorded(const std::vector<ImuSample>& samples, int i) {
    const ImuSample& sample = samples[static_cast<std::size_t>(i)];
    return sample.w_B == i * kAxes && sample.a_B == -i * kAxes;
}

TEST_CASE("a frozen IMU repeats its first readings, each time again, and only of the sensor asked for") {
    const auto both = readings("imu_freeze@2+1");
    const auto gyro = readings("imu_freeze=gyro@2+1");
    for (const int i : {400, 450, 599}) {
        CHECK(both[static_cast<std::size_t>(i)].w_B == 400 * kAxes);
        CHECK(both[static_cast<std::size_t>(i)].a_B == -400 * kAxes);
        CHECK(gyro[static_cast<std::size_t>(i)].w_B == 400 * kAxes);
        CHECK(gyro[static_cast<std::size_t>(i)].a_B == -i * kAxes);
    }
    for (const int i : {0, 399, 600, 1999}) {
        CHECK(is_as_recorded(both, i));
        CHECK(is_as_recorded(gyro, i));
    }
}

TEST_CASE("readings are zero, or no numbers, in their time and their share") {
    const auto zero = readings("imu_zero=accel@2+1");
    CHECK(zero[500].a_B == Eigen::Vector3d::Zero());
    CHECK(zero[500].w_B == 500 * kAxes);
    CHECK(is_as_recorded(zero, 600));
    CHECK(readings("imu_zero")[500].w_B == Eigen::Vector3d::Zero());

    const auto nan = readings("imu_nan=0.25,gyro@2+5");
    int lost = 0;
    for (int i = 400; i < 1400; ++i) {
        const ImuSample& sample = nan[static_cast<std::size_t>(i)];
        lost += sample.w_B.array().isNaN().all() ? 1 : 0;
        CHECK(sample.a_B == -i * kAxes);
    }
    CHECK(lost > 200);
    CHECK(lost < 300);
    CHECK(is_as_recorded(nan, 399));
    CHECK(readings("imu_nan")[700].a_B.array().isNaN().all());
}

TEST_CASE("wrong axes are a cycle, a turn or a mirror") {
    CHECK(readings("imu_axes")[10].w_B == Eigen::Vector3d(2.0, 3.0, 1.0));
    CHECK(readings("imu_axes=turn")[10].w_B == Eigen::Vector3d(-1.0, -2.0, 3.0));
    CHECK(readings("imu_axes=mirror@2")[1000].a_B == Eigen::Vector3d(-100.0, 200.0, -300.0));
    CHECK(is_as_recorded(readings("imu_axes=mirror@2"), 399));
}

TEST_CASE("noise and full scale are of one sensor where that is asked for") {
    const auto noisy = readings("imu_noise=10,accel");
    CHECK(noisy[1000].w_B == 1000 * kAxes);
    CHECK(noisy[1000].a_B != -1000 * kAxes);
    const auto clipped = readings("clip=80,9,gyro@2+1");
    CHECK(clipped[450].w_B == Eigen::Vector3d(9.0, -9.0, 9.0));
    CHECK(clipped[450].a_B == -450 * kAxes);
}

TEST_CASE("rotors shake as many times as strong as they are asked to") {
    const auto once = readings("vibration=flight,3");
    const auto thrice = readings("vibration=flight,3,3");
    for (int i = 0; i < 2000; i += 100) {
        const auto at = static_cast<std::size_t>(i);
        const Eigen::Vector3d shake = once[at].a_B + i * kAxes;
        CHECK((thrice[at].a_B + i * kAxes - 3.0 * shake).norm() < 1e-9);
        CHECK(shake.norm() > 0.0);
    }
}

}  // namespace
}  // namespace facet::inertial_faults_test
