// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/mavlink/mavlink_inertial.h"

#include <cmath>

namespace facet {
namespace {

constexpr double kMilliG = 9.80665e-3;
constexpr double kMilliRadian = 1e-3;
constexpr std::uint16_t kAccelAndGyro = 0x3F;  // bits of HIGHRES_IMU's fields_updated

/// From forward, right, down to forward, left, up.
Eigen::Vector3d to_body(const Eigen::Vector3d& frd) { return {frd.x(), -frd.y(), -frd.z()}; }

Eigen::Vector3d take_floats(MavlinkReader& in) {
    Eigen::Vector3d v;
    for (Eigen::Index i = 0; i < 3; ++i) {
        v[i] = static_cast<double>(in.take_float());
    }
    return v;
}

Eigen::Vector3d take_integers(MavlinkReader& in, double unit) {
    Eigen::Vector3d v;
    for (Eigen::Index i = 0; i < 3; ++i) {
        v[i] = unit * static_cast<double>(in.take<std::int16_t>());
    }
    return v;
}

MavInertial take_highres(MavlinkReader& in) {
    MavInertial inertial;
    inertial.time_us = in.take<std::uint64_t>();
    inertial.a_B = to_body(take_floats(in));
    inertial.w_B = to_body(take_floats(in));
    for (int i = 0; i < 6; ++i) {  // magnetic field, pressures, height
        (void)in.take_float();
    }
    // The temperature is that of the air on some controllers.
    (void)in.take_float();
    inertial.is_complete = (in.take<std::uint16_t>() & kAccelAndGyro) == kAccelAndGyro;
    inertial.id = in.take<std::uint8_t>();
    return inertial;
}

}  // namespace

MavInertial decode_inertial(const MavlinkPacket& packet) {
    MavlinkReader in({packet.payload.data(), packet.payload.size()});
    if (packet.id == MavlinkId::kHighresImu) {
        return take_highres(in);
    }
    MavInertial inertial;
    const bool is_raw = packet.id == MavlinkId::kRawImu;
    inertial.time_us = is_raw ? in.take<std::uint64_t>() : std::uint64_t{1000} * in.take<std::uint32_t>();
    inertial.a_B = to_body(take_integers(in, kMilliG));
    inertial.w_B = to_body(take_integers(in, kMilliRadian));
    (void)take_integers(in, 1.0);  // magnetic field
    inertial.id = is_raw ? in.take<std::uint8_t>() : std::uint8_t{0};
    const auto centidegrees = in.take<std::int16_t>();
    if (centidegrees != 0) {  // no temperature
        inertial.temperature_c = 0.01 * static_cast<double>(centidegrees);
    }
    return inertial;
}

double rounding_of_rates(MavlinkImuMessage message, double rate_hz) {
    return message == MavlinkImuMessage::kHighresImu ? 0.0 : kMilliRadian / std::sqrt(12.0 * rate_hz);
}

double rounding_of_forces(MavlinkImuMessage message, double rate_hz) {
    return message == MavlinkImuMessage::kHighresImu ? 0.0 : kMilliG / std::sqrt(12.0 * rate_hz);
}

}  // namespace facet
