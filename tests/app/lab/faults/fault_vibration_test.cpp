// SPDX-License-Identifier: BSD-2-Clause
// A vibration and the angle it adds up to: one is the other's derivative, it stays small, and both begin as asked.
#include "app/lab/faults/fault_vibration.h"

#include <catch2/catch.hpp>
#include <cmath>

namespace facet::fault_vibration_test {
namespace {

Duration after(double t_s) { return Duration::from_seconds(t_s); }

TEST_CASE("the angle is what the gyroscope's part of the same vibration adds up to") {
    const Fault fault = parse_fault("vibration=flight,5,2,images");
    FaultVibration vibration(fault, 3);
    VibrationAngle angle(fault, 3);
    constexpr double kStep_s = 0.25e-3;
    for (const double begin_s : {0.0, 7.3, 40.0}) {
        // Over a tenth of a second: a period or more of all lines, short against the time constant.
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        const Eigen::Vector3d first = angle.at(after(begin_s));
        for (int k = 0; k < 400; ++k) {
            sum += kStep_s * vibration.at(after(begin_s + (k + 0.5) * kStep_s)).head<3>();
            const Eigen::Vector3d change = angle.at(after(begin_s + (k + 1.0) * kStep_s)) - first;
            CHECK((change - sum).norm() < 2e-4);
        }
        CHECK(angle.at(after(begin_s + 0.013)) != first);
    }
    CHECK(VibrationAngle(fault, 3).at(after(9.0)) != VibrationAngle(fault, 4).at(after(9.0)));
}

TEST_CASE("a flying body turns to and fro by half a milliradian, and never further away") {
    VibrationAngle angle(parse_fault("vibration=flight,1,1,images"), 0);
    Eigen::Vector3d squares = Eigen::Vector3d::Zero();
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double most = 0.0;
    constexpr int kCount = 12'000;  // 60 s
    for (int k = 0; k < kCount; ++k) {
        const Eigen::Vector3d theta = angle.at(after(0.005 * k));
        squares += theta.cwiseAbs2() / kCount;
        sum += theta / kCount;
        most = std::max(most, theta.cwiseAbs().maxCoeff());
    }
    const Eigen::Vector3d rms = squares.cwiseSqrt();
    CHECK(rms.x() == Approx(0.22e-3).epsilon(0.1));
    CHECK(rms.y() == Approx(0.47e-3).epsilon(0.1));
    CHECK(rms.z() == Approx(0.48e-3).epsilon(0.1));
    CHECK(sum.norm() < 0.02e-3);
    CHECK(most < 2.5e-3);
}

TEST_CASE("the angle is the same in any order of times, and begins at zero where the fault does") {
    const Fault always = parse_fault("vibration=flight,1,1,images");
    VibrationAngle angle(always, 0);
    const Eigen::Vector3d late = angle.at(after(3.0));
    CHECK(angle.at(after(1.0)) == VibrationAngle(always, 0).at(after(1.0)));
    CHECK(angle.at(after(3.0)) == late);
    CHECK(angle.at(after(0.0)).norm() > 1e-5);  // it has gone on for long

    VibrationAngle from_two(parse_fault("vibration=flight,1,1,images@2"), 0);
    CHECK(from_two.at(after(1.9)).norm() == 0.0);
    CHECK(from_two.at(after(2.0)).norm() == 0.0);
    CHECK(from_two.at(after(2.02)).norm() > 1e-5);
}

}  // namespace
}  // namespace facet::fault_vibration_test
