// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/mavlink/mavlink_packet.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "drivers/mavlink/mavlink_messages.h"

namespace facet::mavlink_packet_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

Odometry example() {
    Odometry o;
    o.p_W_B = {1, 2, 3};
    o.q_W_B = Eigen::Quaterniond(0.5, 0.5, 0.5, 0.5);  // x of B lies along y of W, y along z, z along x
    o.v_W_B = {0, 4, 0};
    o.w_B = {0.1, 0.2, 0.3};
    o.pose_covariance.diagonal() << 0.01, 0.02, 0.03, 0.001, 0.002, 0.003;
    o.pose_covariance(0, 1) = o.pose_covariance(1, 0) = 0.005;
    o.pose_covariance(1, 2) = o.pose_covariance(2, 1) = 0.004;
    o.v_covariance = Eigen::Vector3d(0.1, 0.2, 0.3).asDiagonal();
    o.w_covariance = Eigen::Vector3d(0.04, 0.05, 0.06).asDiagonal();
    o.quality = 80;
    o.reset_counter = 5;
    return o;
}

Bytes packed(MavlinkId id, const MavlinkPayload& payload, std::uint8_t sequence) {
    MavlinkFrame frame;
    pack_mavlink(id, {payload.data(), payload.size()}, {}, sequence, frame);
    return {frame.begin(), frame.end()};
}

Bytes packed(const Odometry& odometry) {
    FrdOdometry frd;
    REQUIRE(to_frd(odometry, {}, frd) == Status::kOk);
    MavlinkPayload payload;
    encode_odometry(frd, 1'234'567, payload);
    return packed(MavlinkId::kOdometry, payload, 8);
}

/// Made with Python's struct from the values worked out by hand: position (1, -2, -3), attitude (0.5, 0.5, -0.5, -0.5),
/// which is a roll of 90 and a yaw of -90 degrees, velocity (4, 0, 0), rates (0.1, -0.2, -0.3); covariance xy -0.005,
/// yz 0.004, roll 0.001, pitch 0.003, yaw 0.002; velocity's diagonal 0.2, 0.3, 0.1.
const Bytes kGolden{
    0xFD, 0xE9, 0x00, 0x00, 0x08, 0x01, 0xC5, 0x4B, 0x01, 0x00, 0x87, 0xD6, 0x12, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x80, 0x3F, 0x00, 0x00, 0x00, 0xC0, 0x00, 0x00, 0x40, 0xC0, 0x00, 0x00, 0x00, 0x3F, 0x00, 0x00, 0x00, 0x3F,
    0x00, 0x00, 0x00, 0xBF, 0x00, 0x00, 0x00, 0xBF, 0x00, 0x00, 0x80, 0x40, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0xCD, 0xCC, 0xCC, 0x3D, 0xCD, 0xCC, 0x4C, 0xBE, 0x9A, 0x99, 0x99, 0xBE, 0x0A, 0xD7, 0x23, 0x3C, 0x0A, 0xD7,
    0xA3, 0xBB, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x0A,
    0xD7, 0xA3, 0x3C, 0x6F, 0x12, 0x83, 0x3B, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x8F, 0xC2, 0xF5, 0x3C, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x6F, 0x12, 0x83,
    0x3A, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0xA6, 0x9B, 0x44, 0x3B, 0x00, 0x00, 0x00, 0x00, 0x6F, 0x12,
    0x03, 0x3B, 0xCD, 0xCC, 0x4C, 0x3E, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x9A, 0x99, 0x99, 0x3E, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0xCD, 0xCC, 0xCC, 0x3D, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x0A, 0xD7, 0x23, 0x3D, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0xCD, 0xCC,
    0x4C, 0x3D, 0x00, 0x00, 0x00, 0x00, 0x8F, 0xC2, 0x75, 0x3D, 0x14, 0x0C, 0x05, 0x03, 0x50, 0xB8, 0x63};

TEST_CASE("the checksum gives the catalogue's check value") {
    const Bytes text{'1', '2', '3', '4', '5', '6', '7', '8', '9'};
    CHECK(mavlink_crc(text) == 0x6F91);
}

TEST_CASE("golden bytes of ODOMETRY and HEARTBEAT") {
    CHECK(packed(example()) == kGolden);
    MavlinkPayload payload;
    encode(MavHeartbeat{.system_status = kMavStateActive}, payload);
    CHECK(packed(MavlinkId::kHeartbeat, payload, 7) == Bytes{0xFD, 0x09, 0x00, 0x00, 0x07, 0x01, 0xC5,
                                                             0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
                                                             0x12, 0x08, 0x00, 0x04, 0x03, 0x5D, 0x56});
}

TEST_CASE("the other sign of the quaternion gives the same bytes; zeros at the end are cut") {
    Odometry o = example();
    o.q_W_B.coeffs() = -o.q_W_B.coeffs();
    CHECK(packed(o) == kGolden);
    o.quality = 0;
    const Bytes unknown = packed(o);
    CHECK(unknown.size() == kGolden.size() - 1);
    CHECK(unknown[1] == 232);
    o.quality = -1;
    CHECK(packed(o)[10 + 232] == 0xFF);
    const MavlinkPayload zeros = [] {
        MavlinkPayload payload;
        payload.resize(18);
        return payload;
    }();
    CHECK(packed(MavlinkId::kTimesync, zeros, 0).size() == 10 + 1 + 2);
}

TEST_CASE("payloads have the size of their message") {
    MavlinkPayload payload;
    FrdOdometry frd;
    const auto fits = [&](MavlinkId id) {
        return payload.size() == find_mavlink_message(static_cast<std::uint32_t>(id))->size;
    };
    encode(MavHeartbeat{}, payload);
    CHECK(fits(MavlinkId::kHeartbeat));
    encode(MavTimesync{}, payload);
    CHECK(fits(MavlinkId::kTimesync));
    encode(MavCommandAck{}, payload);
    CHECK(fits(MavlinkId::kCommandAck));
    encode_status_text(MavSeverity::kInfo, "", payload);
    CHECK(fits(MavlinkId::kStatusText));
    encode_odometry(frd, 0, payload);
    CHECK(fits(MavlinkId::kOdometry));
    encode_vision_position(frd, 0, payload);
    CHECK(fits(MavlinkId::kVisionPositionEstimate));
    encode_vision_speed(frd, 0, payload);
    CHECK(fits(MavlinkId::kVisionSpeedEstimate));
    encode_obstacles({}, 0, payload);
    CHECK(fits(MavlinkId::kObstacleDistance));
    CHECK(find_mavlink_message(30) == nullptr);
}

TEST_CASE("an unknown range is unknown, not free, a free one is beyond the limit, and one at the limit is a range") {
    ObstacleRanges ranges;
    ranges.max_range_m = 10.0;
    ranges.range_m.fill(std::numeric_limits<float>::quiet_NaN());
    ranges.range_m[0] = 1.234F;
    ranges.range_m[1] = 10.0F;
    ranges.range_m[2] = 10.5F;
    ranges.range_m[3] = 0.001F;
    ranges.range_m[4] = std::numeric_limits<float>::infinity();
    MavlinkPayload payload;
    encode_obstacles(ranges, 5, payload);
    MavlinkReader in({payload.data(), payload.size()});
    CHECK(in.take<std::uint64_t>() == 5);
    std::vector<int> distances;
    for (int i = 0; i < 72; ++i) {
        distances.push_back(in.take<std::uint16_t>());
    }
    CHECK(distances[0] == 123);
    CHECK(distances[1] == 1000);
    CHECK(distances[2] == 65535);
    CHECK(distances[3] == 0);
    CHECK(distances[4] == 1001);
    CHECK(distances[71] == 65535);
    CHECK(in.take<std::uint16_t>() == 0);
    CHECK(in.take<std::uint16_t>() == 1000);
}

TEST_CASE("a long text is cut, and a payload read beyond its end is zero") {
    MavlinkPayload payload;
    encode_status_text(MavSeverity::kWarning, std::string(80, 'x'), payload);
    CHECK(payload[0] == 4);
    CHECK(payload[50] == 'x');
    CHECK(payload[51] == 0);
    const Bytes three{1, 2, 3};
    MavlinkReader in(three);
    CHECK(in.take<std::uint32_t>() == 0x030201);
    CHECK(in.take<std::uint64_t>() == 0);
}

}  // namespace
}  // namespace facet::mavlink_packet_test
