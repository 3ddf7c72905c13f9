// SPDX-License-Identifier: BSD-2-Clause
// Prints frames of random estimates and what they say, for comparison with other readers of the database.
#include <cmath>
#include <cstdio>
#include <string>

#include "drivers/can_out/estimate_frames.h"
#include "drivers/can_out/node_status.h"
#include "tests/drivers/can_out/random_odometry.h"

namespace facet {
namespace {

void print_frame(const CanFrame& frame) {
    std::printf("frame %u %d %d ", static_cast<unsigned>(frame.id), frame.extended ? 1 : 0, frame.fd ? 1 : 0);
    for (const std::uint8_t byte : frame.data()) {
        std::printf("%02x", static_cast<unsigned>(byte));
    }
    std::printf("\n");
}

void expect(const std::string& signal, double value) { std::printf("expect %s %.17g\n", signal.c_str(), value); }

void expect_axes(const std::string& name, const Eigen::Vector3d& value) {
    for (int i = 0; i < 3; ++i) {
        expect(name + "XYZ"[i], value[i]);
    }
}

void print_estimate(std::mt19937& random, unsigned count) {
    const Odometry odometry = test::random_odometry(random);
    const CanFrameInfo info{0x3A0, static_cast<std::uint8_t>(count), Duration::from_seconds(0.001 * count), false};
    expect("Count", count);
    expect("State", static_cast<double>(odometry.state));
    expect("Quality", odometry.quality);
    expect("Resets", odometry.reset_counter);
    expect("Stamp", static_cast<double>(odometry.stamp.ns / 1000) * 1e-6);
    expect("Age", 0.001 * count);
    expect_axes("Position", odometry.p_W_B);
    const double sign = odometry.q_W_B.w() < 0.0 ? -1.0 : 1.0;
    expect("AttitudeW", sign * odometry.q_W_B.w());
    expect_axes("Attitude", sign * odometry.q_W_B.vec());
    expect_axes("Velocity", odometry.v_W_B);
    expect_axes("Rate", odometry.w_B);
    const Eigen::Matrix<double, 6, 1> sigma = odometry.pose_covariance.diagonal().cwiseSqrt();
    expect_axes("PositionSigma", sigma.head<3>());
    expect_axes("AttitudeSigma", sigma.tail<3>());
    expect_axes("VelocitySigma", odometry.v_covariance.diagonal().cwiseSqrt());
    CanFrame fd;
    std::array<CanFrame, kClassicFrames> classic;
    if (ok(encode_fd(odometry, info, fd)) && ok(encode_classic(odometry, info, classic))) {
        print_frame(fd);
        for (const CanFrame& frame : classic) {
            print_frame(frame);
        }
    }
}

void print_health(std::mt19937& random, unsigned k) {
    CanHealth health;
    health.state = static_cast<SinkState>(k % 4);
    health.quality = static_cast<int>(k) - 1;
    health.resets = static_cast<std::uint8_t>(random());
    health.reasons = static_cast<std::uint32_t>(random());
    health.alive = static_cast<std::uint8_t>(k % 16);
    health.age = Duration::from_seconds(0.02 * k);
    expect("State", static_cast<double>(health.state));
    expect("Quality", health.quality);
    expect("Resets", health.resets);
    expect("Reasons", health.reasons);
    expect("Alive", health.alive);
    expect("Age", 0.02 * k);
    print_frame(encode_health(health, 0x3A0));
}

}  // namespace
}  // namespace facet

/// Lines: "expect SIGNAL VALUE" for each signal of the estimate that follows, then "frame ID EXTENDED FD DATA" of its
/// frames. Without arguments.
int main() {
    std::mt19937 random(5);  // NOLINT(cert-msc51-cpp): fixed on purpose
    for (unsigned k = 0; k < 100; ++k) {
        facet::print_estimate(random, k);
        facet::print_health(random, k);
    }
    return 0;
}
