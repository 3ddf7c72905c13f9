// SPDX-License-Identifier: BSD-2-Clause
#include "tests/hil/inject/imu_encoding.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>

#include "drivers/imu_can/dbc_decoder.h"
#include "drivers/imu_can/dronecan.h"
#include "drivers/imu_can/openimu300.h"
#include "drivers/imu_spi/icm42688.h"
#include "platform/base/angle.h"

namespace facet::hil {
namespace {

constexpr double kIcmRate = 2000.0 * kRadPerDeg / 524288.0;
constexpr double kIcmForce = 16.0 * kStandardGravity / 524288.0;
constexpr double kAdisRate = kRadPerDeg / 40.0;
constexpr double kAdisForce = kStandardGravity / 4000.0;
constexpr double kBmiRate = 2000.0 * kRadPerDeg / 32767.0;
constexpr double kBmiForce = 12.0 * kStandardGravity / 32768.0;
// As iio_imu.c tells its scales: nine digits behind the point.
constexpr double kIioRate = 0.000066579;
constexpr double kIioForce = 0.004788403;
constexpr std::uint32_t kRawImuId = (8U << 24) | (1003U << 8) | 42U;  // priority, type, node
constexpr std::uint32_t kOpenImuRateId = 0x0CF02A80;
constexpr std::uint32_t kOpenImuForceId = 0x0CF02D80;

std::int32_t counts(double value, double scale, std::int32_t most) {
    return static_cast<std::int32_t>(std::clamp<double>(std::round(value / scale), -most, most));
}

void put_big16(std::uint8_t* at, std::int32_t value) {
    at[0] = static_cast<std::uint8_t>((static_cast<std::uint32_t>(value) >> 8) & 0xFFU);
    at[1] = static_cast<std::uint8_t>(static_cast<std::uint32_t>(value) & 0xFFU);
}

void put_little(std::uint8_t* at, std::uint32_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) {
        at[i] = static_cast<std::uint8_t>((value >> (8 * i)) & 0xFFU);
    }
}

void put_float(std::uint8_t* at, double value) {
    put_little(at, std::bit_cast<std::uint32_t>(static_cast<float>(value)), 4);
}

std::uint16_t crc16(std::uint16_t crc, std::uint8_t byte) {
    std::uint32_t value = crc ^ (static_cast<std::uint32_t>(byte) << 8);
    for (int bit = 0; bit < 8; ++bit) {
        value = (value & 0x8000U) != 0 ? (value << 1) ^ 0x1021U : value << 1;
    }
    return static_cast<std::uint16_t>(value & 0xFFFFU);
}

template <class Decoder>
ImuSample decoded(Decoder& decoder, const std::vector<CanFrame>& frames, const ImuSample& sample) {
    ImuSample result = sample;
    int parts = 0;
    for (const CanFrame& frame : frames) {
        CanMeasurement measurement;
        if (!ok(decoder.decode(frame, measurement))) {
            continue;
        }
        if (measurement.rate) {
            result.w_B = *measurement.rate;
            ++parts;
        }
        if (measurement.force) {
            result.a_B = *measurement.force;
            ++parts;
        }
    }
    if (parts != 2) {
        throw std::runtime_error("a sample cannot be decoded after it was encoded");
    }
    return result;
}

ImuSample as_read_from_adis(const ImuSample& sample) {
    ImuSample result = sample;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
        result.w_B[axis] = counts(sample.w_B[axis], kAdisRate, 32767) * kAdisRate;
        result.a_B[axis] = counts(sample.a_B[axis], kAdisForce, 32767) * kAdisForce;
    }
    return result;
}

/// The mount matrix leads back to the axes of the sample.
ImuSample as_read_from_iio(const ImuSample& sample) {
    const std::array<std::int32_t, 6> sensor = iio_counts(sample);
    ImuSample result = sample;
    result.w_B = Eigen::Vector3d(-sensor[1], sensor[0], sensor[2]) * kIioRate;
    result.a_B = Eigen::Vector3d(-sensor[4], sensor[3], sensor[5]) * kIioForce;
    return result;
}

/// As bmi_registers() writes and Bmi088 and ImuAssembler read them.
std::vector<ImuSample> as_read_from_bmi(const std::vector<ImuSample>& samples) {
    std::vector<ImuSample> measured = samples;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const Eigen::Vector3d force = force_at(samples, i > 0 ? i - 1 : 0, samples[i].stamp - kBmiForceAge);
        for (Eigen::Index axis = 0; axis < 3; ++axis) {
            measured[i].w_B[axis] = counts(samples[i].w_B[axis], kBmiRate, 32767) * kBmiRate;
            measured[i].a_B[axis] = counts(force[axis], kBmiForce, 32767) * kBmiForce;
        }
    }
    for (std::size_t i = 0; i + 1 < measured.size(); ++i) {
        const double share = kBmiForceAgeRead.seconds() / (measured[i + 1].stamp - measured[i].stamp).seconds();
        measured[i].a_B += share * (measured[i + 1].a_B - measured[i].a_B);
    }
    measured.pop_back();
    return measured;
}

ImuSample decoded_openimu(const ImuSample& sample) {
    DbcFile database;
    DbcDecoder decoder;
    std::string error;
    if (!ok(database.parse(openimu300_dbc(), "openimu300", error)) ||
        !ok(decoder.configure(database, openimu300_map(), error))) {
        throw std::runtime_error(error);
    }
    return decoded(decoder, openimu_frames(sample), sample);
}

}  // namespace

std::array<std::uint8_t, 20> icm_packet(const ImuSample& sample, std::uint16_t time_us) {
    std::array<std::uint8_t, 20> packet{};
    packet[0] = 0x78;  // force, rate, their extension, time of the sample
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto index = static_cast<Eigen::Index>(axis);
        // -524288 would be the mark of an invalid value.
        const std::int32_t force = counts(sample.a_B[index], kIcmForce, 524287);
        const std::int32_t rate = counts(sample.w_B[index], kIcmRate, 524287);
        put_big16(&packet[1 + 2 * axis], force >> 4);
        put_big16(&packet[7 + 2 * axis], rate >> 4);
        packet[17 + axis] = static_cast<std::uint8_t>(((force & 0xF) << 4) | (rate & 0xF));
    }
    put_big16(&packet[15], time_us);
    return packet;
}

std::array<std::uint8_t, 20> adis_burst(const ImuSample& sample, std::uint16_t counter) {
    std::array<std::uint8_t, 20> burst{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto index = static_cast<Eigen::Index>(axis);
        put_big16(&burst[2 + 2 * axis], counts(sample.w_B[index], kAdisRate, 32767));
        put_big16(&burst[8 + 2 * axis], counts(sample.a_B[index], kAdisForce, 32767));
    }
    put_big16(&burst[14], 250);  // 25 deg C
    put_big16(&burst[16], counter);
    std::int32_t sum = 0;
    for (std::size_t i = 0; i < 18; ++i) {
        sum += burst[i];
    }
    put_big16(&burst[18], sum);
    return burst;
}

std::array<std::int32_t, 6> iio_counts(const ImuSample& sample) {
    const auto rate = [&](double value) { return counts(value, kIioRate, 524287); };
    const auto force = [&](double value) { return counts(value, kIioForce, 32767); };
    const Eigen::Vector3d& w = sample.w_B;
    const Eigen::Vector3d& a = sample.a_B;
    return {rate(w.y()), rate(-w.x()), rate(w.z()), force(a.y()), force(-a.x()), force(a.z())};
}

Eigen::Vector3d force_at(const std::vector<ImuSample>& samples, std::size_t before, Timestamp stamp) {
    const ImuSample& a = samples[before];
    const ImuSample& b = samples[std::min(before + 1, samples.size() - 1)];
    if (stamp <= a.stamp || b.stamp <= a.stamp) {
        return a.a_B;
    }
    return a.a_B + (stamp - a.stamp).seconds() / (b.stamp - a.stamp).seconds() * (b.a_B - a.a_B);
}

std::array<std::uint8_t, 15> bmi_registers(const ImuSample& rate, const Eigen::Vector3d& force, std::uint32_t count) {
    constexpr std::uint32_t kSamplesPerEdge = 8;  // 1600 and 200 Hz
    constexpr std::uint32_t kTicksPerSample = 16;
    constexpr std::uint32_t kAge = 8;  // ticks
    std::array<std::uint8_t, 15> bytes{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto index = static_cast<Eigen::Index>(axis);
        put_little(&bytes[2 * axis], static_cast<std::uint32_t>(counts(rate.w_B[index], kBmiRate, 32767)), 2);
        put_little(&bytes[6 + 2 * axis], static_cast<std::uint32_t>(counts(force[index], kBmiForce, 32767)), 2);
    }
    put_little(&bytes[12], count * kSamplesPerEdge * kTicksPerSample + kAge, 3);
    return bytes;
}

std::vector<CanFrame> dronecan_frames(const ImuSample& sample, Duration interval, std::uint8_t transfer) {
    constexpr std::size_t kPayload = 47;
    std::array<std::uint8_t, 2 + kPayload> bytes{};
    std::uint8_t* const payload = &bytes[2];
    const double interval_s = static_cast<float>(interval.seconds());
    put_float(payload + 7, interval_s);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto index = static_cast<Eigen::Index>(axis);
        constexpr std::uint32_t kNotANumber = 0x7E00;  // the latest values are not given, only integrals
        put_little(payload + 11 + 2 * axis, kNotANumber, 2);
        put_float(payload + 17 + 4 * axis, sample.w_B[index] * interval_s);
        put_little(payload + 29 + 2 * axis, kNotANumber, 2);
        put_float(payload + 35 + 4 * axis, sample.a_B[index] * interval_s);
    }
    std::uint16_t crc = 0xFFFF;
    for (int i = 0; i < 8; ++i) {
        crc = crc16(crc, static_cast<std::uint8_t>(DroneCanDecoder::kSignature >> (8 * i)));
    }
    for (std::size_t i = 0; i < kPayload; ++i) {
        crc = crc16(crc, payload[i]);
    }
    put_little(bytes.data(), crc, 2);
    std::vector<CanFrame> frames;
    for (std::size_t at = 0; at < bytes.size(); at += 7) {
        CanFrame frame;
        frame.id = kRawImuId;
        frame.extended = true;
        const std::size_t size = std::min<std::size_t>(7, bytes.size() - at);
        std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), size, frame.bytes.begin());
        const bool is_last = at + size == bytes.size();
        frame.bytes[size] = static_cast<std::uint8_t>((at == 0 ? 0x80 : 0) | (is_last ? 0x40 : 0) |
                                                      (frames.size() % 2 == 1 ? 0x20 : 0) | (transfer & 0x1F));
        frame.length = static_cast<std::uint8_t>(size + 1);
        frames.push_back(frame);
    }
    return frames;
}

std::vector<CanFrame> openimu_frames(const ImuSample& sample) {
    CanFrame rate;
    rate.id = kOpenImuRateId;
    rate.extended = true;
    rate.length = 8;
    rate.bytes.fill(0xFF);
    CanFrame force = rate;
    force.id = kOpenImuForceId;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto index = static_cast<Eigen::Index>(axis);
        const double rate_deg = sample.w_B[index] / kRadPerDeg;
        put_little(&rate.bytes[2 * axis], static_cast<std::uint32_t>(counts(rate_deg + 250.0, 1.0 / 128.0, 64255)), 2);
        put_little(&force.bytes[2 * axis], static_cast<std::uint32_t>(counts(sample.a_B[index] + 320.0, 0.01, 64255)),
                   2);
    }
    return {rate, force};
}

namespace {

ImuSample as_encoded(ImuKind kind, const ImuSample& sample, Duration interval) {
    switch (kind) {
        case ImuKind::kIcm42688: {
            const Result<IcmPacket> packet = parse_icm_packet(icm_packet(sample, 0));
            if (!packet.ok()) {
                throw std::runtime_error("a packet of the ICM-42688-P cannot be decoded after it was encoded");
            }
            ImuSample result = sample;
            result.w_B = packet.value().rate;
            result.a_B = packet.value().force;
            return result;
        }
        case ImuKind::kDroneCan: {
            DroneCanDecoder decoder(DroneCanOptions{.use_integrals = true});
            return decoded(decoder, dronecan_frames(sample, interval, 0), sample);
        }
        case ImuKind::kOpenImu300: return decoded_openimu(sample);
        case ImuKind::kIio: return as_read_from_iio(sample);
        default: return as_read_from_adis(sample);
    }
}

}  // namespace

std::vector<ImuSample> as_encoded(ImuKind kind, const std::vector<ImuSample>& samples, Duration interval) {
    if (kind == ImuKind::kBmi088) {
        return as_read_from_bmi(samples);
    }
    std::vector<ImuSample> result;
    for (const ImuSample& sample : samples) {
        result.push_back(as_encoded(kind, sample, interval));
    }
    return result;
}

}  // namespace facet::hil
