// SPDX-License-Identifier: BSD-2-Clause
// Frames read back through the database that describes them, by the reader of the IMU driver.
#include "drivers/can_out/estimate_frames.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>

#include "drivers/can_out/node_status.h"
#include "drivers/imu_can/dbc_file.h"
#include "tests/drivers/can_out/random_odometry.h"

namespace facet::estimate_frames_test {
namespace {

const DbcFile& database() {
    static const DbcFile file = [] {
        std::ifstream stream(FACET_DBC, std::ios::binary);
        const std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
        DbcFile read;
        std::string error;
        REQUIRE(ok(read.parse(text, "facet.dbc", error)));
        return read;
    }();
    return file;
}

/// Value of a signal of one of the frames that has it; every frame's length must be the database's.
template <class Frames>
double read(const Frames& frames, const std::string& signal) {
    for (const CanFrame& frame : frames) {
        for (const DbcMessage& message : database().messages()) {
            const DbcSignal* const found = message.find(signal);
            if (message.id == frame.id && found != nullptr) {
                CHECK(message.length == frame.length);
                CHECK(message.extended == frame.extended);
                const Result<double> value = message.value(*found, frame.data());
                REQUIRE(value.ok());
                return value.value();
            }
        }
    }
    FAIL("no frame has the signal " << signal);
    return 0.0;
}

template <class Frames>
Eigen::Vector3d read_axes(const Frames& frames, const std::string& name) {
    return {read(frames, name + "X"), read(frames, name + "Y"), read(frames, name + "Z")};
}

/// Steps of the attitude and of what else is coarser in classic frames.
struct Steps {
    double attitude;
    double velocity;
    double rate;
};

template <class Frames>
void check_frames(const Frames& frames, const Odometry& sent, const Steps& steps) {
    const auto is_near = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b, double step) {
        return (a - b).cwiseAbs().maxCoeff() <= 0.5001 * step;
    };
    const double sign = sent.q_W_B.w() < 0.0 ? -1.0 : 1.0;
    CHECK(std::abs(read(frames, "Stamp") - static_cast<double>(sent.stamp.ns / 1000) * 1e-6) < 1e-7);
    CHECK(is_near(read_axes(frames, "Position"), sent.p_W_B, 1e-4));
    CHECK(std::abs(read(frames, "AttitudeW") - sign * sent.q_W_B.w()) <= 0.5001 * steps.attitude);
    CHECK(is_near(read_axes(frames, "Attitude"), sign * sent.q_W_B.vec(), steps.attitude));
    CHECK(is_near(read_axes(frames, "Velocity"), sent.v_W_B, steps.velocity));
    CHECK(is_near(read_axes(frames, "Rate"), sent.w_B, steps.rate));
    const Eigen::Matrix<double, 6, 1> sigma = sent.pose_covariance.diagonal().cwiseSqrt();
    CHECK(is_near(read_axes(frames, "PositionSigma"), sigma.head<3>(), 2e-4));
    CHECK(is_near(read_axes(frames, "AttitudeSigma"), sigma.tail<3>(), 1e-4));
    CHECK(is_near(read_axes(frames, "VelocitySigma"), sent.v_covariance.diagonal().cwiseSqrt(), 2e-4));
    CHECK(read(frames, "Quality") == sent.quality);
    CHECK(read(frames, "Resets") == sent.reset_counter);
    CHECK(read(frames, "State") == static_cast<double>(sent.state));
    CHECK(read(frames, "Age") == Approx(0.012));
    for (const CanFrame& frame : frames) {
        CHECK(read(std::array{frame}, "Count") == 77);
    }
}

TEST_CASE("estimates are read back to half a step of each signal") {
    std::mt19937 random(1);  // NOLINT(cert-msc51-cpp): fixed on purpose
    const CanFrameInfo info{0x3A0, 77, Duration::from_seconds(0.012), true};
    for (int i = 0; i < 50; ++i) {
        const Odometry odometry = test::random_odometry(random);
        std::array<CanFrame, kClassicFrames> classic;
        REQUIRE(ok(encode_classic(odometry, info, classic)));
        check_frames(classic, odometry, {1.25e-4, 5e-4, 5e-4});
        std::array<CanFrame, 1> fd;
        REQUIRE(ok(encode_fd(odometry, info, fd[0])));
        CHECK(fd[0].fd);
        CHECK(fd[0].bit_rate_switch);
        check_frames(fd, odometry, {4e-5, 1e-4, 2e-3});
    }
}

TEST_CASE("each identifier of the database is used, from the first one on") {
    CHECK(database().messages().size() == kCanOutIds);
    for (std::uint32_t i = 0; i < kCanOutIds; ++i) {
        CHECK(database().messages()[i].id == 0x3A0 + i);
    }
    std::array<CanFrame, kClassicFrames> classic;
    CanFrame fd;
    REQUIRE(ok(encode_classic({}, {.first_id = 0x100, .age = {}}, classic)));
    REQUIRE(ok(encode_fd({}, {.first_id = 0x100, .age = {}}, fd)));
    CHECK(encode_health({}, 0x100).id == 0x100);
    CHECK(fd.id == 0x101);
    CHECK(classic.front().id == 0x102);
    CHECK(classic.back().id == 0x10A);
}

TEST_CASE("what lies outside of a signal's range is sent as its limit, and no sigma is zero") {
    Odometry odometry;
    odometry.p_W_B = {1e6, -1e6, 0.0};
    odometry.v_W_B = {1e3, -1e3, 0.0};
    odometry.pose_covariance.diagonal() << 1e6, 1e-12, 1.0, 1.0, 1.0, 1.0;
    std::array<CanFrame, kClassicFrames> frames;
    REQUIRE(ok(encode_classic(odometry, {.age = Duration::from_seconds(9.0)}, frames)));
    CHECK(read(frames, "PositionX") == Approx(13421.7727));
    CHECK(read(frames, "PositionY") == Approx(-13421.7728));
    CHECK(read(frames, "VelocityX") == Approx(65.5355));
    CHECK(read(frames, "PositionSigmaX") == Approx(13.107));
    CHECK(read(frames, "PositionSigmaY") == Approx(0.0002));
    CHECK(read(frames, "Age") == Approx(0.255));
    REQUIRE(ok(encode_classic(odometry, {.age = Duration::from_seconds(-9.0)}, frames)));  // a stamp in the future
    CHECK(read(frames, "Age") == 0.0);
}

TEST_CASE("what is no estimate is not sent") {
    std::array<CanFrame, kClassicFrames> frames;
    frames[0].length = 3;
    const auto refuses = [&](auto change) {
        Odometry odometry;
        change(odometry);
        CanFrame fd;
        CHECK(encode_fd(odometry, {}, fd) == Status::kInvalidArgument);
        CHECK(encode_classic(odometry, {}, frames) == Status::kInvalidArgument);
        CHECK(frames[0].length == 3);
    };
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    refuses([](Odometry& o) { o.p_W_B.y() = kNan; });
    refuses([](Odometry& o) { o.v_W_B.z() = std::numeric_limits<double>::infinity(); });
    refuses([](Odometry& o) { o.w_B.x() = kNan; });
    refuses([](Odometry& o) { o.q_W_B.w() = kNan; });
    refuses([](Odometry& o) { o.pose_covariance(4, 4) = 0.0; });
    refuses([](Odometry& o) { o.v_covariance(0, 0) = -1.0; });
}

TEST_CASE("health is read back") {
    CanHealth health{SinkState::kDegraded, -1, 200, 0x8003'0001U, 9, Duration::from_seconds(1.5)};
    const std::array frames{encode_health(health, 0x3A0)};
    CHECK(read(frames, "State") == 2);
    CHECK(read(frames, "Quality") == -1);
    CHECK(read(frames, "Resets") == 200);
    CHECK(read(frames, "Reasons") == 0x8003'0001U);
    CHECK(read(frames, "Alive") == 9);
    CHECK(read(frames, "Age") == Approx(1.5));
    CHECK(read(std::array{encode_health({}, 0x3A0)}, "Age") == Approx(2.55));
}

TEST_CASE("DroneCAN's node status has the bytes of its definition") {
    const CanFrame frame = encode_node_status({42, 0x01020304, SinkState::kDegraded, 0xABCDEFU, 33});
    CHECK(frame.extended);
    CHECK(frame.id == ((24U << 24) | (341U << 8) | 42U));
    CHECK(frame.length == 8);
    // uptime, then health WARNING (1) and mode OPERATIONAL (0), the vendor's code, the tail.
    const std::array<std::uint8_t, 8> bytes{0x04, 0x03, 0x02, 0x01, 0x40, 0xEF, 0xCD, 0xC1};
    CHECK(std::equal(bytes.begin(), bytes.end(), frame.bytes.begin()));
    CHECK(encode_node_status({1, 0, SinkState::kInit, 0, 0}).bytes[4] == 0x08);  // OK, INITIALIZATION
    CHECK(encode_node_status({1, 0, SinkState::kTracking, 0, 0}).bytes[4] == 0x00);
    CHECK(encode_node_status({1, 0, SinkState::kLost, 0, 0}).bytes[4] == 0x80);  // ERROR
}

}  // namespace
}  // namespace facet::estimate_frames_test
