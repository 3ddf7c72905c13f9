// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/sink_mavlink/mavlink_frame.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace facet {
namespace {

constexpr std::uint8_t kMagic = 0xFD;  // MAVLink 2
constexpr std::uint32_t kOdometryId = 331;
constexpr std::uint8_t kOdometryCrcExtra = 91;
constexpr std::uint32_t kHeartbeatId = 0;
constexpr std::uint8_t kHeartbeatCrcExtra = 50;
constexpr std::uint8_t kFrameBodyFrd = 12;
constexpr std::uint8_t kFrameLocalFrd = 20;
constexpr std::uint8_t kEstimatorVio = 3;
constexpr std::uint8_t kTypeOnboardController = 18;
constexpr std::uint8_t kAutopilotInvalid = 8;
constexpr std::uint8_t kStateActive = 4;
constexpr std::uint8_t kProtocolVersion = 3;
constexpr std::size_t kHeaderSize = 10;

/// Little-endian payload; MAVLink orders fields by size, largest first.
class Payload {
public:
    template <class T>
    void put(T value) {
        for (std::size_t i = 0; i < sizeof(T); ++i) {
            bytes_.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8 * i)));
        }
    }
    /// Adding zero makes -0 a +0: equal estimates give equal bytes.
    void put_float(double value) { put(std::bit_cast<std::uint32_t>(static_cast<float>(value) + 0.0F)); }
    template <class Vector>
    void put_vector(const Vector& v) {
        for (Eigen::Index i = 0; i < v.size(); ++i) {
            put_float(v[i]);
        }
    }
    void put_upper_triangle(const Matrix6d& m) {
        for (Eigen::Index row = 0; row < 6; ++row) {
            for (Eigen::Index column = row; column < 6; ++column) {
                put_float(m(row, column));
            }
        }
    }
    std::span<const std::uint8_t> bytes() const { return {bytes_.data(), bytes_.size()}; }

private:
    FixedVector<std::uint8_t, 255> bytes_;
};

void wrap(std::span<const std::uint8_t> payload, std::uint32_t id, std::uint8_t crc_extra,
          const MavlinkAddress& address, std::uint8_t sequence, MavlinkFrame& frame) {
    // Trailing zeros are cut off, except the first byte.
    std::size_t size = payload.size();
    while (size > 1 && payload[size - 1] == 0) {
        --size;
    }
    const std::array<std::uint8_t, kHeaderSize> header{kMagic,
                                                       static_cast<std::uint8_t>(size),
                                                       0,
                                                       0,
                                                       sequence,
                                                       address.system,
                                                       address.component,
                                                       static_cast<std::uint8_t>(id & 0xFFU),
                                                       static_cast<std::uint8_t>((id >> 8) & 0xFFU),
                                                       static_cast<std::uint8_t>(id >> 16)};
    frame.resize(kHeaderSize + size);
    std::copy(header.begin(), header.end(), frame.begin());
    std::copy_n(payload.begin(), size, frame.begin() + kHeaderSize);
    const std::uint16_t body = mavlink_crc(std::span<const std::uint8_t>(frame.data(), frame.size()).subspan(1));
    const std::uint16_t crc = mavlink_crc(std::span(&crc_extra, 1), body);
    frame.push_back(static_cast<std::uint8_t>(crc & 0xFFU));
    frame.push_back(static_cast<std::uint8_t>(crc >> 8));
}

bool is_usable(const Odometry& o) {
    const bool finite = o.q_W_B.coeffs().allFinite() && o.p_W_B.allFinite() && o.v_W_B.allFinite() &&
                        o.w_B.allFinite() && o.pose_covariance.allFinite() && o.v_covariance.allFinite() &&
                        o.w_covariance.allFinite();
    return finite && std::abs(o.q_W_B.norm() - 1.0) < 1e-3 && (o.pose_covariance.diagonal().array() > 0.0).all() &&
           (o.v_covariance.diagonal().array() > 0.0).all() && (o.w_covariance.diagonal().array() > 0.0).all() &&
           o.quality >= -1 && o.quality <= 100;
}

}  // namespace

std::uint16_t mavlink_crc(std::span<const std::uint8_t> bytes, std::uint16_t initial) {
    std::uint32_t crc = initial;
    for (const std::uint8_t byte : bytes) {
        crc ^= byte;
        for (int bit = 0; bit < 8; ++bit) {
            crc = (crc & 1U) != 0 ? (crc >> 1) ^ 0x8408U : crc >> 1;
        }
    }
    return static_cast<std::uint16_t>(crc);
}

Status encode_odometry(const Odometry& odometry, const MavlinkAddress& address, std::uint8_t sequence,
                       MavlinkFrame& frame) {
    if (!is_usable(odometry)) {
        return Status::kInvalidArgument;
    }
    const Eigen::Vector3d flip(1.0, -1.0, -1.0);
    const Eigen::Matrix3d R_B_W = odometry.q_W_B.normalized().toRotationMatrix().transpose();
    Matrix6d flip6 = Matrix6d::Identity();
    flip6.diagonal() << flip, flip;
    Matrix6d velocity_covariance = Matrix6d::Zero();
    velocity_covariance.topLeftCorner<3, 3>() = R_B_W * odometry.v_covariance * R_B_W.transpose();
    velocity_covariance.bottomRightCorner<3, 3>() = odometry.w_covariance;

    // D q D^-1 with D a half turn about x: y and z of the quaternion change sign. Of q and -q, the one with w >= 0 is
    // sent.
    Eigen::Vector4d q_wxyz(odometry.q_W_B.w(), odometry.q_W_B.x(), -odometry.q_W_B.y(), -odometry.q_W_B.z());
    q_wxyz = q_wxyz.normalized() * (q_wxyz[0] < 0.0 ? -1.0 : 1.0);

    Payload payload;
    payload.put(static_cast<std::uint64_t>(odometry.stamp.ns / 1000));
    payload.put_vector(odometry.p_W_B.cwiseProduct(flip));
    payload.put_vector(q_wxyz);
    payload.put_vector((R_B_W * odometry.v_W_B).cwiseProduct(flip));
    payload.put_vector(odometry.w_B.cwiseProduct(flip));
    payload.put_upper_triangle(flip6 * odometry.pose_covariance * flip6);
    payload.put_upper_triangle(flip6 * velocity_covariance * flip6);
    payload.put(kFrameLocalFrd);
    payload.put(kFrameBodyFrd);
    payload.put(odometry.reset_counter);
    payload.put(kEstimatorVio);
    payload.put(static_cast<std::uint8_t>(static_cast<std::int8_t>(odometry.quality)));
    wrap(payload.bytes(), kOdometryId, kOdometryCrcExtra, address, sequence, frame);
    return Status::kOk;
}

void encode_heartbeat(const MavlinkAddress& address, std::uint8_t sequence, MavlinkFrame& frame) {
    Payload payload;
    payload.put(std::uint32_t{0});  // custom mode
    payload.put(kTypeOnboardController);
    payload.put(kAutopilotInvalid);
    payload.put(std::uint8_t{0});  // base mode
    payload.put(kStateActive);
    payload.put(kProtocolVersion);
    wrap(payload.bytes(), kHeartbeatId, kHeartbeatCrcExtra, address, sequence, frame);
}

}  // namespace facet
