// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/imu_spi/icm42688.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace facet {
namespace {

// Register map: TDK data sheet DS-000347 (ICM-42688-P), sections 13 (bank 0) and 6 (FIFO packets); FIFO packet,
// header bits and self-test limits compared with PX4's ICM42688P and TDK's Icm426xxSelfTest sources.
constexpr std::uint8_t kDeviceConfig = 0x11;
constexpr std::uint8_t kIntConfig = 0x14;
constexpr std::uint8_t kFifoConfig = 0x16;
constexpr std::uint8_t kAccelData = 0x1F;  // 6 bytes of force, then 6 of rate
constexpr std::uint8_t kFifoCount = 0x2E;
constexpr std::uint8_t kFifoData = 0x30;
constexpr std::uint8_t kSignalPathReset = 0x4B;
constexpr std::uint8_t kIntfConfig0 = 0x4C;
constexpr std::uint8_t kPwrMgmt0 = 0x4E;
constexpr std::uint8_t kGyroConfig0 = 0x4F;
constexpr std::uint8_t kAccelConfig0 = 0x50;
constexpr std::uint8_t kTmstConfig = 0x54;
constexpr std::uint8_t kFifoConfig1 = 0x5F;
constexpr std::uint8_t kFifoConfig2 = 0x60;  // watermark, low byte; high byte in the next register
constexpr std::uint8_t kFsyncConfig = 0x62;
constexpr std::uint8_t kIntConfig1 = 0x64;
constexpr std::uint8_t kIntSource0 = 0x65;
constexpr std::uint8_t kSelfTestConfig = 0x70;
constexpr std::uint8_t kWhoAmI = 0x75;
constexpr std::uint8_t kBankSelect = 0x76;

constexpr std::uint8_t kIdentity = 0x47;
constexpr std::uint8_t kSoftReset = 0x01;
constexpr std::uint8_t kFlushFifo = 0x02;
constexpr std::uint8_t kInt1PushPullHigh = 0x03;  // pulsed, push-pull, active high
constexpr std::uint8_t kStream = 0x40;
constexpr std::uint8_t kCountRecordsBigEndian = 0x70;  // FIFO_COUNT_REC, both big-endian bits
constexpr std::uint8_t kLowNoiseBoth = 0x0F;
constexpr std::uint8_t kTimeMicroseconds = 0x21;  // TMST_EN, resolution 1 us, absolute; bit 5 is reserved and set
constexpr std::uint8_t kHighResolution = 0x3F;    // watermark by threshold, 20 bits, time, temperature, rate, force
constexpr std::uint8_t kFifoThresholdToInt1 = 0x04;
constexpr std::uint8_t kSelfTestAll = 0x7F;  // power for it, three gyroscope and three accelerometer axes

constexpr std::uint8_t kHeaderEmpty = 0x80;
constexpr std::uint8_t kHeaderKind = 0xF0;
constexpr std::uint8_t kHeader20Bit = 0x70;  // force, rate and their extension
constexpr std::uint8_t kHeaderTime = 0x0C;
constexpr std::uint8_t kHeaderOdrTime = 0x08;

constexpr double kRateScale = 2000.0 * kRadPerDeg / 524288.0;
constexpr double kForceScale = 16.0 * kStandardGravity / 524288.0;
constexpr double kRateScale16 = 2000.0 * kRadPerDeg / 32768.0;
constexpr double kForceScale16 = 16.0 * kStandardGravity / 32768.0;
// Self-test responses where no factory values are used (TDK: at least 60 deg/s; 50 mg to 1200 mg).
constexpr double kMinRateResponse = 60.0 * kRadPerDeg;
constexpr double kMinForceResponse = 0.050 * kStandardGravity;
constexpr double kMaxForceResponse = 1.200 * kStandardGravity;
constexpr int kSelfTestSamples = 50;
constexpr int kMergedAtMost = 10;  // edges in a row
constexpr double kPredictedPeriods = 10.5;
// Share of a new measurement of the clock ratio, and how far off nominal the oscillator may be.
constexpr double kRatioGain = 0.02;
constexpr double kMaxRatioError = 0.08;

std::int32_t big16(std::span<const std::uint8_t> bytes, std::size_t at) {
    return static_cast<std::int16_t>((bytes[at] << 8) | bytes[at + 1]);
}

std::uint8_t rate_code(std::uint16_t rate_hz) {
    switch (rate_hz) {
        case 200: return 0x07;
        case 500: return 0x0F;
        case 1000: return 0x06;
        case 2000: return 0x05;
        default: return 0;
    }
}

}  // namespace

Result<IcmPacket> parse_icm_packet(std::span<const std::uint8_t, IcmPacket::kSize> bytes) {
    const std::uint8_t header = bytes[0];
    IcmPacket packet;
    // An unplugged bus reads all ones, which would be an "empty" header with more bits set.
    if ((header & kHeaderEmpty) != 0) {
        packet.empty = true;
        return header == 0xFF ? Result<IcmPacket>(Status::kCorrupt) : Result<IcmPacket>(packet);
    }
    if ((header & kHeaderKind) != kHeader20Bit || (header & kHeaderTime) != kHeaderOdrTime) {
        return Status::kCorrupt;
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::int32_t force = big16(bytes, 1 + 2 * axis) * 16 + (bytes[17 + axis] >> 4);
        const std::int32_t rate = big16(bytes, 7 + 2 * axis) * 16 + (bytes[17 + axis] & 0x0F);
        if (force == -524288 || rate == -524288) {
            return Status::kCorrupt;
        }
        packet.force[static_cast<Eigen::Index>(axis)] = force * kForceScale;
        packet.rate[static_cast<Eigen::Index>(axis)] = rate * kRateScale;
    }
    packet.temperature_c = big16(bytes, 13) / 132.48 + 25.0;
    packet.time = static_cast<std::uint16_t>((bytes[15] << 8) | bytes[16]);
    return packet;
}

Status Icm42688::reset_and_identify(std::string& problem) {
    FACET_TRY(bus_.write(kBankSelect, 0));
    FACET_TRY(bus_.write(kDeviceConfig, kSoftReset));
    clock_.sleep(Duration::from_seconds(0.002));
    std::uint8_t identity = 0;
    FACET_TRY(bus_.read(kWhoAmI, identity));
    if (identity != kIdentity) {
        problem = "ICM-42688-P: WHO_AM_I is " + std::to_string(identity) + ", expected " + std::to_string(kIdentity);
        return Status::kNotFound;
    }
    FACET_TRY(bus_.write(kIntfConfig0, kCountRecordsBigEndian));
    // +-2000 deg/s and +-16 g, which the 20-bit format has anyway.
    FACET_TRY(bus_.write(kGyroConfig0, rate_code(options_.rate_hz)));
    FACET_TRY(bus_.write(kAccelConfig0, rate_code(options_.rate_hz)));
    FACET_TRY(bus_.write(kPwrMgmt0, kLowNoiseBoth));
    clock_.sleep(Duration::from_seconds(0.050));  // the gyroscope starts in 45 ms
    return Status::kOk;
}

Status Icm42688::average(Eigen::Vector3d& rate, Eigen::Vector3d& force) {
    rate.setZero();
    force.setZero();
    for (int i = 0; i < kSelfTestSamples; ++i) {
        clock_.sleep(Duration::from_seconds(1.0 / options_.rate_hz));
        std::array<std::uint8_t, 12> bytes{};
        FACET_TRY(bus_.read(kAccelData, bytes));
        for (Eigen::Index axis = 0; axis < 3; ++axis) {
            force[axis] += big16(bytes, 2 * static_cast<std::size_t>(axis)) * kForceScale16 / kSelfTestSamples;
            rate[axis] += big16(bytes, 6 + 2 * static_cast<std::size_t>(axis)) * kRateScale16 / kSelfTestSamples;
        }
    }
    return Status::kOk;
}

Status Icm42688::self_test(std::string& problem) {
    Eigen::Vector3d rate;
    Eigen::Vector3d force;
    Eigen::Vector3d rate_tested;
    Eigen::Vector3d force_tested;
    FACET_TRY(average(rate, force));
    FACET_TRY(bus_.write(kSelfTestConfig, kSelfTestAll));
    clock_.sleep(Duration::from_seconds(0.200));
    FACET_TRY(average(rate_tested, force_tested));
    FACET_TRY(bus_.write(kSelfTestConfig, 0));
    clock_.sleep(Duration::from_seconds(0.100));
    const Eigen::Array3d rate_response = (rate_tested - rate).array().abs();
    const Eigen::Array3d force_response = (force_tested - force).array().abs();
    const bool rate_good = (rate_response >= kMinRateResponse).all();
    const bool force_good = (force_response >= kMinForceResponse).all() && (force_response <= kMaxForceResponse).all();
    if (!rate_good || !force_good) {
        problem =
            std::string("ICM-42688-P: self-test of the ") + (rate_good ? "accelerometer" : "gyroscope") + " failed";
        return Status::kIo;
    }
    return Status::kOk;
}

Status Icm42688::flush() {
    any_packet_ = false;
    any_edge_ = false;
    merged_in_a_row_ = 0;
    any_empty_ = false;
    return bus_.write(kSignalPathReset, kFlushFifo);
}

Status Icm42688::set_up(std::string& problem) {
    const std::array<std::array<std::uint8_t, 2>, 9> settings{{{kIntConfig, kInt1PushPullHigh},
                                                               {kIntConfig1, 0},  // as the data sheet requires
                                                               {kTmstConfig, kTimeMicroseconds},
                                                               {kFsyncConfig, 0},  // no tags in the packets
                                                               {kFifoConfig2, options_.watermark},
                                                               {kFifoConfig2 + 1, 0},
                                                               {kFifoConfig1, kHighResolution},
                                                               {kIntSource0, kFifoThresholdToInt1},
                                                               {kFifoConfig, kStream}}};
    for (const auto& [address, value] : settings) {
        FACET_TRY(bus_.write(address, value));
        std::uint8_t back = 0;
        FACET_TRY(bus_.read(address, back));
        if (back != value) {
            problem = "ICM-42688-P: register " + std::to_string(address) + " did not keep its setting";
            return Status::kIo;
        }
    }
    return flush();
}

Status Icm42688::configure(SelfTest test, std::string& problem) {
    problem.clear();
    if (rate_code(options_.rate_hz) == 0 || options_.watermark < 1 || options_.watermark > 50) {
        problem = "ICM-42688-P: the rate must be 200, 500, 1000 or 2000 Hz and the watermark 1 to 50";
        return Status::kInvalidArgument;
    }
    Status status = bus_.device().open({3, 8'000'000});
    status = ok(status) ? reset_and_identify(problem) : status;
    status = ok(status) && test == SelfTest::kRun && options_.self_test ? self_test(problem) : status;
    status = ok(status) ? set_up(problem) : status;
    if (!ok(status) && problem.empty()) {
        problem = bus_.device().problem();
    }
    return status;
}

/// Which packet made the edge: the one that filled the watermark. But two edges that come before the kernel's thread
/// has run are one event with the later one's stamp: if that packet's time is off by more than half a period and
/// another one's fits, it was that one. If it was not, and the reader is late only, an edge follows that finds no
/// packet: an assumption that meets this kMergedAtMost times in a row is dropped.
std::size_t Icm42688::packet_at(const TriggerEdge& edge, std::span<const std::int64_t> times_us) {
    const std::size_t usual = std::min<std::size_t>(options_.watermark, times_us.size()) - 1;
    // Beyond some periods the ratio of the clocks is not known well enough for a prediction.
    if (!any_edge_ || static_cast<double>(times_us[usual] - edge_time_us_) > kPredictedPeriods * nominal_us()) {
        return usual;
    }
    const auto off_us = [&](std::size_t i) {
        const double predicted_us = static_cast<double>(times_us[i] - edge_time_us_) * ratio_;
        return std::abs(static_cast<double>((edge.stamp - edge_stamp_).ns) * 1e-3 - predicted_us);
    };
    std::size_t best = usual;
    for (std::size_t i = usual + 1; i < times_us.size(); ++i) {
        best = off_us(i) < off_us(best) ? i : best;
    }
    const bool is_merged = off_us(usual) > 0.5 * nominal_us() && off_us(best) < 0.25 * nominal_us();
    merged_in_a_row_ = is_merged ? merged_in_a_row_ + (any_empty_ ? 1 : 0) : 0;
    return is_merged && merged_in_a_row_ <= kMergedAtMost ? best : usual;
}

void Icm42688::follow_clock(const TriggerEdge& edge, std::int64_t time_us) {
    if (any_edge_ && time_us > edge_time_us_) {
        const double measured =
            static_cast<double>((edge.stamp - edge_stamp_).ns) * 1e-3 / static_cast<double>(time_us - edge_time_us_);
        if (std::abs(measured - 1.0) < kMaxRatioError) {
            ratio_ += kRatioGain * (measured - ratio_);
        }
    }
    any_edge_ = true;
    edge_stamp_ = edge.stamp;
    edge_time_us_ = time_us;
}

Status Icm42688::read(const TriggerEdge& edge, SpiMeasurements& out) {
    std::array<std::uint8_t, 2> count_bytes{};
    FACET_TRY(bus_.read(kFifoCount, count_bytes));
    const std::size_t count = (static_cast<std::size_t>(count_bytes[0]) << 8) | count_bytes[1];
    if (count == 0) {
        any_empty_ = true;
        return Status::kNotReady;
    }
    if (count > kMaxPackets + 4) {  // 2 KB and the packets in flight; more means an unplugged bus
        return Status::kCorrupt;
    }
    std::array<std::uint8_t, kMaxPackets * IcmPacket::kSize> bytes{};
    const std::size_t wanted = std::min(count, kMaxPackets);
    FACET_TRY(bus_.read(kFifoData, std::span(bytes).first(wanted * IcmPacket::kSize)));
    std::array<std::int64_t, kMaxPackets> times_us{};
    const std::size_t first = out.size();
    bool corrupt = false;
    for (std::size_t i = 0; i < wanted; ++i) {
        const std::span<const std::uint8_t, IcmPacket::kSize> one(bytes.data() + i * IcmPacket::kSize,
                                                                  IcmPacket::kSize);
        const Result<IcmPacket> packet = parse_icm_packet(one);
        if (!packet.ok()) {
            corrupt = true;
            continue;
        }
        if (packet.value().empty) {
            break;
        }
        SpiMeasurement m;
        const auto step_us = static_cast<std::uint16_t>(packet.value().time - static_cast<std::uint16_t>(time_us_));
        time_us_ += step_us;
        if (any_packet_) {
            const double periods = step_us / nominal_us();
            m.lost = periods > 1.5 ? static_cast<std::uint32_t>(std::lround(periods) - 1) : 0;
        }
        any_packet_ = true;
        m.rate = packet.value().rate;
        m.force = packet.value().force;
        m.temperature_c = packet.value().temperature_c;
        times_us[out.size() - first] = time_us_;
        FACET_TRY(out.try_push_back(m));
    }
    const std::size_t got = out.size() - first;
    if (got == 0) {
        return corrupt ? Status::kCorrupt : Status::kNotReady;
    }
    const std::size_t at_edge = packet_at(edge, std::span(times_us).first(got));
    any_empty_ = false;
    follow_clock(edge, times_us[at_edge]);
    for (std::size_t i = 0; i < got; ++i) {
        const double offset_ns = static_cast<double>(times_us[i] - times_us[at_edge]) * ratio_ * 1e3;
        out[first + i].stamp = edge.stamp + Duration{std::llround(offset_ns)};
    }
    return corrupt ? Status::kCorrupt : Status::kOk;
}

}  // namespace facet
