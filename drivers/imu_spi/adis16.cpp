// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/imu_spi/adis16.h"

#include <algorithm>
#include <cmath>

namespace facet {
namespace {

// Registers, bits, scales and times as in Linux' drivers/iio/imu/adis16400.c (ADIS16448) and adis16475.c (the others),
// and in PX4's ADIS16448 driver for CRC, self-test and stall time; both follow Analog Devices' data sheets.
constexpr std::uint8_t kWrite = 0x80;
namespace adis16448 {
constexpr std::uint8_t kMscCtrl = 0x34;
constexpr std::uint8_t kSmplPrd = 0x36;
constexpr std::uint8_t kDiagStat = 0x3C;
constexpr std::uint8_t kGlobCmd = 0x3E;  // reading it starts a burst
constexpr std::uint8_t kProdId = 0x56;
constexpr std::uint16_t kCrcInBurst = 1U << 4;
constexpr std::uint16_t kDataReadyHighOnDio1 = 0x0006;
constexpr std::uint16_t kSelfTest = 1U << 10;
constexpr std::uint16_t kInternalClock = 1U << 0;
constexpr std::uint16_t kSelfTestFailures = 0xFC20;  // bit 5: any; 10 to 15: gyroscope x to accelerometer z
constexpr std::size_t kWords = 13;  // DIAG_STAT, 3 rates, 3 forces, 3 fields, pressure, temperature, CRC
constexpr std::size_t kTemperature = 11;
constexpr std::uint16_t kStall_us = 9;
constexpr double kReset_s = 0.090;
constexpr double kSelfTest_s = 0.045;
}  // namespace adis16448
namespace adis1647x {
constexpr std::uint8_t kDiagStat = 0x02;
constexpr std::uint8_t kRangMdl = 0x5E;
constexpr std::uint8_t kMscCtrl = 0x60;
constexpr std::uint8_t kDecRate = 0x64;
constexpr std::uint8_t kGlobCmd = 0x68;  // reading it starts a burst
constexpr std::uint8_t kProdId = 0x72;
constexpr std::uint16_t kMscDefault = 0x00C1;  // data ready active high, g compensation and point of percussion on
constexpr std::uint16_t kSelfTest = 1U << 2;
constexpr std::uint16_t kSensorFailure = 1U << 5;
constexpr std::uint16_t kUntrusted = (1U << 1) | (1U << 5) | (1U << 7);  // overrun, sensor failure, clock error
constexpr std::size_t kWords = 10;  // DIAG_STAT, 3 rates, 3 forces, temperature, counter, checksum
constexpr std::size_t kTemperature = 7;
constexpr std::size_t kCounter = 8;
constexpr std::uint16_t kStall_us = 16;
constexpr double kReset_s = 0.200;
constexpr double kSelfTest_s = 0.020;
}  // namespace adis1647x
constexpr std::uint16_t kSoftwareReset = 1U << 7;

// Rate: 25 LSB/(deg/s) [16448, +-1000 deg/s], 10 [16470, 16475-3, +-2000], 40 [16475-2, +-500], 160 [16475-1, +-125].
// Force: 1200 LSB/g [16448], 800 [16470, +-40 g], 4000 [16475, +-8 g].
constexpr std::array<Adis16Variant, 5> kVariants{{
    {"ADIS16448", 0x4040, kRadPerDeg / 25.0, kStandardGravity / 1200.0, 0.07386, 31.0, 819.2, true, -1},
    {"ADIS16470", 0x4056, kRadPerDeg / 10.0, kStandardGravity / 800.0, 0.1, 0.0, 2000.0, false, -1},
    {"ADIS16475-1", 0x405B, kRadPerDeg / 160.0, kStandardGravity / 4000.0, 0.1, 0.0, 2000.0, false, 0},
    {"ADIS16475-2", 0x405B, kRadPerDeg / 40.0, kStandardGravity / 4000.0, 0.1, 0.0, 2000.0, false, 1},
    {"ADIS16475-3", 0x405B, kRadPerDeg / 10.0, kStandardGravity / 4000.0, 0.1, 0.0, 2000.0, false, 3},
}};

double signed_word(std::uint16_t word) { return static_cast<std::int16_t>(word); }

Eigen::Vector3d vector_at(std::span<const std::uint16_t> words, std::size_t at, double scale) {
    return Eigen::Vector3d(signed_word(words[at]), signed_word(words[at + 1]), signed_word(words[at + 2])) * scale;
}

}  // namespace

const Adis16Variant& adis16_variant(Adis16Model model) { return kVariants[static_cast<std::size_t>(model)]; }

std::uint16_t adis16448_crc(std::span<const std::uint16_t> words) {
    std::uint32_t crc = 0xFFFF;
    for (const std::uint16_t word : words) {
        // Low byte first, least significant bit first: the word's bits in ascending order.
        for (int bit = 0; bit < 16; ++bit) {
            const bool carry = ((crc ^ (static_cast<std::uint32_t>(word) >> bit)) & 1U) != 0;
            crc = carry ? (crc >> 1) ^ 0x1021U : crc >> 1;
        }
    }
    crc = ~crc & 0xFFFFU;
    return static_cast<std::uint16_t>((crc << 8) | (crc >> 8));
}

std::uint16_t adis1647x_checksum(std::span<const std::uint16_t> words) {
    std::uint32_t sum = 0;
    for (const std::uint16_t word : words) {
        sum += (word >> 8) + (word & 0xFFU);
    }
    return static_cast<std::uint16_t>(sum);
}

double Adis16::rate_hz() const {
    return variant_.is_16448 ? variant_.internal_rate_hz / std::exp2(options_.decimation)
                             : variant_.internal_rate_hz / (options_.decimation + 1.0);
}

Status Adis16::read_register(std::uint8_t address, std::uint16_t& value) {
    const std::uint16_t stall_us = variant_.is_16448 ? adis16448::kStall_us : adis1647x::kStall_us;
    const std::array<std::uint8_t, 2> command{address, 0};
    std::array<std::uint8_t, 2> answer{};
    // The answer comes with the next frame.
    const std::array<SpiSegment, 2> segments{
        {{command.data(), nullptr, 2, stall_us, true}, {nullptr, answer.data(), 2, stall_us, false}}};
    FACET_TRY(bus_.transfer(segments));
    value = static_cast<std::uint16_t>((answer[0] << 8) | answer[1]);
    return Status::kOk;
}

Status Adis16::write_register(std::uint8_t address, std::uint16_t value) {
    const std::uint16_t stall_us = variant_.is_16448 ? adis16448::kStall_us : adis1647x::kStall_us;
    const std::array<std::uint8_t, 4> out{
        static_cast<std::uint8_t>(kWrite | address), static_cast<std::uint8_t>(value & 0xFFU),
        static_cast<std::uint8_t>(kWrite | (address + 1U)), static_cast<std::uint8_t>(value >> 8)};
    const std::array<SpiSegment, 2> segments{
        {{out.data(), nullptr, 2, stall_us, true}, {out.data() + 2, nullptr, 2, stall_us, false}}};
    return bus_.transfer(segments);
}

Status Adis16::write_checked(std::uint8_t address, std::uint16_t value) {
    FACET_TRY(write_register(address, value));
    clock_.sleep(Duration::from_seconds(0.001));
    std::uint16_t back = 0;
    FACET_TRY(read_register(address, back));
    return back == value ? Status::kOk : Status::kCorrupt;
}

Status Adis16::reset_and_identify(std::string& problem) {
    const bool old = variant_.is_16448;
    FACET_TRY(write_register(old ? adis16448::kGlobCmd : adis1647x::kGlobCmd, kSoftwareReset));
    clock_.sleep(Duration::from_seconds(old ? adis16448::kReset_s : adis1647x::kReset_s));
    std::uint16_t id = 0;
    FACET_TRY(read_register(old ? adis16448::kProdId : adis1647x::kProdId, id));
    if (id != variant_.product_id) {
        problem = std::string(variant_.name) + ": product id is " + std::to_string(id) + ", expected " +
                  std::to_string(variant_.product_id);
        return Status::kNotFound;
    }
    if (variant_.range_code < 0) {
        return Status::kOk;
    }
    std::uint16_t range = 0;
    FACET_TRY(read_register(adis1647x::kRangMdl, range));
    if (((range >> 2) & 3U) != static_cast<unsigned>(variant_.range_code)) {
        problem =
            std::string(variant_.name) + ": the chip has a different range (RANG_MDL " + std::to_string(range) + ")";
        return Status::kNotFound;
    }
    return Status::kOk;
}

Status Adis16::self_test(std::string& problem) {
    const bool old = variant_.is_16448;
    FACET_TRY(old ? write_register(adis16448::kMscCtrl, adis16448::kSelfTest)
                  : write_register(adis1647x::kGlobCmd, adis1647x::kSelfTest));
    clock_.sleep(Duration::from_seconds(old ? adis16448::kSelfTest_s : adis1647x::kSelfTest_s));
    std::uint16_t diagnosis = 0;
    FACET_TRY(read_register(old ? adis16448::kDiagStat : adis1647x::kDiagStat, diagnosis));
    if ((diagnosis & (old ? adis16448::kSelfTestFailures : adis1647x::kSensorFailure)) != 0) {
        problem = std::string(variant_.name) + ": self-test failed (DIAG_STAT " + std::to_string(diagnosis) + ")";
        return Status::kIo;
    }
    return Status::kOk;
}

Status Adis16::set_up(std::string& problem) {
    Status status = Status::kOk;
    if (variant_.is_16448) {
        status = write_checked(adis16448::kMscCtrl, adis16448::kCrcInBurst | adis16448::kDataReadyHighOnDio1);
        if (ok(status)) {
            status = write_checked(adis16448::kSmplPrd,
                                   static_cast<std::uint16_t>((options_.decimation << 8) | adis16448::kInternalClock));
        }
    } else {
        status = write_checked(adis1647x::kMscCtrl, adis1647x::kMscDefault);
        if (ok(status)) {
            status = write_checked(adis1647x::kDecRate, options_.decimation);
        }
    }
    if (status == Status::kCorrupt) {
        problem = std::string(variant_.name) + ": a setting was not retained";
        return Status::kIo;
    }
    return status;
}

Status Adis16::configure(SelfTest test, std::string& problem) {
    any_read_ = false;
    // Clock idle high, sampled on the rising edge; 1 MHz is the most that bursts allow.
    Status status = bus_.open({3, 1'000'000});
    problem.clear();
    status = ok(status) ? reset_and_identify(problem) : status;
    status = ok(status) && test == SelfTest::kRun && options_.self_test ? self_test(problem) : status;
    status = ok(status) ? set_up(problem) : status;
    if (!ok(status) && problem.empty()) {
        problem = bus_.problem();
    }
    return status;
}

Status Adis16::burst(Words& words) {
    const std::size_t count = variant_.is_16448 ? adis16448::kWords : adis1647x::kWords;
    std::array<std::uint8_t, 2 + 2 * kMaxWords> out{};
    std::array<std::uint8_t, 2 + 2 * kMaxWords> in{};
    out[0] = variant_.is_16448 ? adis16448::kGlobCmd : adis1647x::kGlobCmd;
    const SpiSegment segment{out.data(), in.data(), 2 + 2 * count, 0, false};
    FACET_TRY(bus_.transfer(std::span(&segment, 1)));
    for (std::size_t i = 0; i < count; ++i) {
        words[i] = static_cast<std::uint16_t>((in[2 + 2 * i] << 8) | in[3 + 2 * i]);
    }
    return Status::kOk;
}

bool Adis16::intact(const Words& words) const {
    const std::size_t count = variant_.is_16448 ? adis16448::kWords : adis1647x::kWords;
    const std::span<const std::uint16_t> all = std::span(words).first(count);
    // A dead bus gives zeros, whose sum is right.
    if (std::all_of(all.begin(), all.end(), [](std::uint16_t w) { return w == 0; })) {
        return false;
    }
    if (variant_.is_16448) {
        return adis16448_crc(all.subspan(1, count - 2)) == all[count - 1];
    }
    return adis1647x_checksum(all.first(count - 1)) == all[count - 1] && (all[0] & adis1647x::kUntrusted) == 0;
}

Status Adis16::count(const Words& words, const TriggerEdge& edge, SpiMeasurement& measurement) {
    const std::uint32_t edges = edge.sequence - edge_sequence_;
    if (variant_.is_16448) {
        measurement.lost = any_read_ && edges > 1 ? edges - 1 : 0;
    } else {
        const std::uint16_t counter = words[adis1647x::kCounter];
        const auto step = static_cast<std::uint16_t>(counter - counter_);
        if (any_read_ && step == 0) {
            edge_sequence_ = edge.sequence;
            return Status::kNotReady;
        }
        measurement.lost = any_read_ ? step - 1U : 0;
        if (any_read_ && edges > 0 && step == edges + 1) {
            // Read so late that the next sample had replaced the one of this edge; the next edge will find nothing new.
            // Or two edges were one event with the later one's stamp: that is told by when the sample was due.
            const Duration half{static_cast<std::int64_t>(0.5e9 / rate_hz())};
            const Timestamp due = last_stamp_ + Duration{2 * half.ns * step};
            if (due - measurement.stamp > half) {
                measurement.stamp = measurement.stamp + Duration{2 * half.ns};
            }
        }
        counter_ = counter;
        last_stamp_ = measurement.stamp;
    }
    edge_sequence_ = edge.sequence;
    any_read_ = true;
    return Status::kOk;
}

Status Adis16::read(const TriggerEdge& edge, SpiMeasurements& out) {
    Words words{};
    FACET_TRY(burst(words));
    if (!intact(words)) {
        return Status::kCorrupt;
    }
    SpiMeasurement measurement;
    measurement.stamp = edge.stamp;
    FACET_TRY(count(words, edge, measurement));
    measurement.rate = vector_at(words, 1, variant_.rate_scale);
    measurement.force = vector_at(words, 4, variant_.force_scale);
    std::uint16_t temperature = words[variant_.is_16448 ? adis16448::kTemperature : adis1647x::kTemperature];
    if (variant_.is_16448) {
        // 12 bits, two's complement.
        temperature =
            static_cast<std::uint16_t>((temperature & 0x800U) != 0 ? temperature | 0xF000U : temperature & 0xFFFU);
    }
    measurement.temperature_c = signed_word(temperature) * variant_.temperature_scale + variant_.temperature_offset;
    return out.try_push_back(measurement);
}

}  // namespace facet
