// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/imu_spi/bmi088.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "drivers/common/stamp_fault.h"

namespace facet {
namespace {

// Bosch data sheet BST-BMI088-DS001 rev. 1.3, sections 4.6 (self-test), 5.3 (accelerometer) and 5.5 (gyroscope). The
// self-test procedure gives 0xA7 for ACC_CONF, which is 50 Hz, and "1.6 kHz", which is 0xAC: the latter is used. The
// factor 1.5 of the accelerometer's scale is missing in that revision's formula but follows from the ranges (3 to 24
// g).
namespace accel {
constexpr std::uint8_t kChipId = 0x00;
constexpr std::uint8_t kData = 0x12;  // 6 bytes of data and 3 of sensor time
constexpr std::uint8_t kTemperature = 0x22;
constexpr std::uint8_t kConf = 0x40;
constexpr std::uint8_t kRange = 0x41;
constexpr std::uint8_t kSelfTest = 0x6D;
constexpr std::uint8_t kPwrConf = 0x7C;
constexpr std::uint8_t kPwrCtrl = 0x7D;
constexpr std::uint8_t kSoftReset = 0x7E;
constexpr std::uint8_t kIdentity = 0x1E;
constexpr std::uint8_t kNormal1600Hz = 0xAC;  // bandwidth "normal" (about 145 Hz at 1600 Hz output), 1600 Hz
constexpr std::uint8_t kRange24g = 3;
constexpr std::uint8_t kPositive = 0x0D;
constexpr std::uint8_t kNegative = 0x09;
constexpr std::uint32_t kTicksPerSample = 16;
constexpr double kTick_ns = 39062.5;
}  // namespace accel
namespace gyro {
constexpr std::uint8_t kChipId = 0x00;
constexpr std::uint8_t kData = 0x02;
constexpr std::uint8_t kRange = 0x0F;
constexpr std::uint8_t kBandwidth = 0x10;
constexpr std::uint8_t kSoftReset = 0x14;
constexpr std::uint8_t kIntCtrl = 0x15;
constexpr std::uint8_t kInt34Conf = 0x16;
constexpr std::uint8_t kInt34Map = 0x18;
constexpr std::uint8_t kSelfTest = 0x3C;
constexpr std::uint8_t kIdentity = 0x0F;
constexpr std::uint8_t kRange2000 = 0;
constexpr std::uint8_t kDataReady = 0x80;
constexpr std::uint8_t kInt3PushPullHigh = 0x01;
constexpr std::uint8_t kDataReadyToInt3 = 0x01;
constexpr std::uint8_t kTrigger = 0x01;
constexpr std::uint8_t kTestReady = 0x02;
constexpr std::uint8_t kTestFailed = 0x04;
constexpr double kScale = 2000.0 * kRadPerDeg / 32767.0;
}  // namespace gyro
constexpr std::uint8_t kReset = 0xB6;
constexpr std::uint32_t kTemperatureEvery = 256;  // reads; it changes every 1.28 s

Eigen::Vector3d vector_at(std::span<const std::uint8_t> bytes, double scale) {
    Eigen::Vector3d v;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
        const auto i = 2 * static_cast<std::size_t>(axis);
        v[axis] = static_cast<std::int16_t>((bytes[i + 1] << 8) | bytes[i]) * scale;
    }
    return v;
}

double force_scale(std::uint8_t range_code) { return 1.5 * std::exp2(range_code + 1) * kStandardGravity / 32768.0; }

/// GYRO_BANDWIDTH: rate and filter; 0 if there is no such rate.
std::uint8_t gyro_rate_code(std::uint16_t rate_hz) {
    switch (rate_hz) {
        case 200: return 0x84;   // 23 Hz
        case 400: return 0x83;   // 47 Hz
        case 1000: return 0x82;  // 116 Hz
        case 2000: return 0x81;  // 230 Hz
        default: return 0;
    }
}

}  // namespace

Status Bmi088::failed(SpiDevice& device) {
    problem_ = device.problem();
    return Status::kIo;
}

void Bmi088::close() {
    gyro_.device().close();
    accel_.device().close();
}

Status Bmi088::start_accelerometer(SelfTest test, std::string& problem) {
    std::uint8_t id = 0;
    // The first read after power-on only switches the interface to SPI.
    FACET_TRY(accel_.read(accel::kChipId, id));
    FACET_TRY(accel_.write(accel::kSoftReset, kReset));
    clock_.sleep(Duration::from_seconds(0.002));
    FACET_TRY(accel_.read(accel::kChipId, id));
    FACET_TRY(accel_.read(accel::kChipId, id));
    if (id != accel::kIdentity) {
        problem =
            "BMI088 accelerometer: chip id is " + std::to_string(id) + ", expected " + std::to_string(accel::kIdentity);
        return Status::kNotFound;
    }
    FACET_TRY(accel_.write(accel::kPwrConf, 0x00));
    clock_.sleep(Duration::from_seconds(0.001));
    FACET_TRY(accel_.write(accel::kPwrCtrl, 0x04));
    clock_.sleep(Duration::from_seconds(0.050));
    if (test == SelfTest::kRun) {
        FACET_TRY(test_accelerometer(problem));
    }
    FACET_TRY(accel_.write(accel::kConf, accel::kNormal1600Hz));
    FACET_TRY(accel_.write(accel::kRange, options_.force_range_code));
    std::uint8_t range = 0xFF;
    FACET_TRY(accel_.read(accel::kRange, range));
    if ((range & 0x03U) != options_.force_range_code) {
        problem = "BMI088 accelerometer: the range was not retained";
        return Status::kIo;
    }
    return Status::kOk;
}

Status Bmi088::test_accelerometer(std::string& problem) {
    FACET_TRY(accel_.write(accel::kRange, accel::kRange24g));
    FACET_TRY(accel_.write(accel::kConf, accel::kNormal1600Hz));
    clock_.sleep(Duration::from_seconds(0.003));
    std::array<Eigen::Vector3d, 2> responses;
    const std::array<std::uint8_t, 2> polarities{accel::kPositive, accel::kNegative};
    for (std::size_t i = 0; i < 2; ++i) {
        FACET_TRY(accel_.write(accel::kSelfTest, polarities[i]));
        clock_.sleep(Duration::from_seconds(0.060));
        std::array<std::uint8_t, 6> bytes{};
        FACET_TRY(accel_.read(accel::kData, bytes));
        responses[i] = vector_at(bytes, force_scale(accel::kRange24g));
    }
    FACET_TRY(accel_.write(accel::kSelfTest, 0));
    clock_.sleep(Duration::from_seconds(0.060));
    const Eigen::Vector3d difference_g = (responses[0] - responses[1]) / kStandardGravity;
    if (difference_g.x() < 1.0 || difference_g.y() < 1.0 || difference_g.z() < 0.5) {
        problem = "BMI088 accelerometer: self-test failed";
        return Status::kIo;
    }
    return Status::kOk;
}

Status Bmi088::start_gyro(SelfTest test, std::string& problem) {
    FACET_TRY(gyro_.write(gyro::kSoftReset, kReset));
    clock_.sleep(Duration::from_seconds(0.035));
    std::uint8_t id = 0;
    FACET_TRY(gyro_.read(gyro::kChipId, id));
    if (id != gyro::kIdentity) {
        problem =
            "BMI088 gyroscope: chip id is " + std::to_string(id) + ", expected " + std::to_string(gyro::kIdentity);
        return Status::kNotFound;
    }
    if (test == SelfTest::kRun) {
        FACET_TRY(test_gyro(problem));
    }
    FACET_TRY(gyro_.write(gyro::kRange, gyro::kRange2000));
    FACET_TRY(gyro_.write(gyro::kBandwidth, gyro_rate_code(options_.gyro_rate_hz)));
    FACET_TRY(gyro_.write(gyro::kInt34Conf, gyro::kInt3PushPullHigh));
    FACET_TRY(gyro_.write(gyro::kInt34Map, gyro::kDataReadyToInt3));
    FACET_TRY(gyro_.write(gyro::kIntCtrl, gyro::kDataReady));
    std::uint8_t bandwidth = 0;
    FACET_TRY(gyro_.read(gyro::kBandwidth, bandwidth));
    // Bit 7 always reads 1.
    if ((bandwidth | 0x80U) != gyro_rate_code(options_.gyro_rate_hz)) {
        problem = "BMI088 gyroscope: the rate was not retained";
        return Status::kIo;
    }
    return Status::kOk;
}

Status Bmi088::test_gyro(std::string& problem) {
    FACET_TRY(gyro_.write(gyro::kSelfTest, gyro::kTrigger));
    std::uint8_t result = 0;
    for (int attempt = 0; attempt < 20 && (result & gyro::kTestReady) == 0; ++attempt) {
        clock_.sleep(Duration::from_seconds(0.005));
        FACET_TRY(gyro_.read(gyro::kSelfTest, result));
    }
    if ((result & gyro::kTestReady) == 0 || (result & gyro::kTestFailed) != 0) {
        problem = "BMI088 gyroscope: self-test failed";
        return Status::kIo;
    }
    return Status::kOk;
}

Status Bmi088::configure(SelfTest test, std::string& problem) {
    problem.clear();
    test = options_.self_test ? test : SelfTest::kSkip;
    if (gyro_rate_code(options_.gyro_rate_hz) == 0 || options_.force_range_code > 3) {
        problem = "BMI088: the gyroscope's rate must be 200, 400, 1000 or 2000 Hz and the range code 0 to 3";
        return Status::kInvalidArgument;
    }
    any_force_ = false;
    any_rate_ = false;
    SpiDevice* device = &accel_.device();
    Status status = device->open({3, 8'000'000});
    status = ok(status) ? start_accelerometer(test, problem) : status;
    if (ok(status)) {
        device = &gyro_.device();
        status = device->open({3, 8'000'000});
        status = ok(status) ? start_gyro(test, problem) : status;
    }
    if (!ok(status) && problem.empty()) {
        problem = device->problem();
    }
    return status;
}

Status Bmi088::read_force(SpiMeasurement& measurement) {
    std::array<std::uint8_t, 9> bytes{};
    if (!ok(accel_.read(accel::kData, bytes))) {
        return failed(accel_.device());
    }
    const Timestamp now = now_by(clock_, options_.clock);
    const std::uint32_t time = static_cast<std::uint32_t>(bytes[6] | (bytes[7] << 8) | (bytes[8] << 16));
    const bool dead = std::all_of(bytes.begin(), bytes.end(), [&](std::uint8_t b) { return b == bytes[0]; }) &&
                      (bytes[0] == 0x00 || bytes[0] == 0xFF);
    if (dead) {
        return Status::kCorrupt;
    }
    const std::uint32_t sample = time / accel::kTicksPerSample;
    if (any_force_ && sample == sensor_time_ / accel::kTicksPerSample) {
        return Status::kNotReady;  // the same sample as before
    }
    any_force_ = true;
    sensor_time_ = time;
    const double age_ns = static_cast<double>(time % accel::kTicksPerSample) * accel::kTick_ns;
    measurement.stamp = now - Duration{std::llround(age_ns)};
    measurement.force = vector_at(bytes, force_scale(options_.force_range_code));
    return Status::kOk;
}

Status Bmi088::read(const TriggerEdge& edge, SpiMeasurements& out) {
    // From the chip's identity on, two registers before the rates, which look the same on a dead line and at rest.
    std::array<std::uint8_t, 8> bytes{};
    static_assert(gyro::kData == gyro::kChipId + 2);
    if (!ok(gyro_.read(gyro::kChipId, bytes))) {
        return failed(gyro_.device());
    }
    if (bytes[0] != gyro::kIdentity) {
        return Status::kCorrupt;
    }
    SpiMeasurement force;
    const Status force_status = read_force(force);
    if (force_status == Status::kIo || force_status == Status::kCorrupt) {
        return force_status;
    }
    if (reads_++ % kTemperatureEvery == 0) {
        std::array<std::uint8_t, 2> temperature{};
        if (ok(accel_.read(accel::kTemperature, temperature)) && temperature[0] != 0x80) {
            const int raw = temperature[0] * 8 + temperature[1] / 32;
            temperature_c_ = (raw > 1023 ? raw - 2048 : raw) * 0.125 + 23.0;
        }
    }
    if (ok(force_status)) {
        FACET_TRY(out.try_push_back(force));
    }
    SpiMeasurement rate;
    rate.stamp = edge.stamp;
    rate.rate = vector_at(std::span(bytes).last<6>(), gyro::kScale);
    rate.temperature_c = temperature_c_;
    const std::uint32_t edges = edge.sequence - edge_sequence_;
    rate.lost = any_rate_ && edges > 1 ? edges - 1 : 0;
    any_rate_ = true;
    edge_sequence_ = edge.sequence;
    return out.try_push_back(rate);
}

}  // namespace facet
