// SPDX-License-Identifier: BSD-2-Clause
// Bosch BMI088: a gyroscope and an accelerometer in one case, with separate chip selects and no common clock.
#pragma once

#include <cstdint>

#include "drivers/imu_spi/register_bus.h"
#include "drivers/imu_spi/spi_imu_chip.h"
#include "platform/port/clock.h"

namespace facet {

struct Bmi088Options {
    std::uint16_t gyro_rate_hz = 400;   ///< 200, 400, 1000 or 2000; its edge drives the reading
    std::uint8_t force_range_code = 2;  ///< 0: 3 g, 1: 6 g, 2: 12 g, 3: 24 g
    bool self_test = true;
    ClockDomain clock =
        ClockDomain::kMonotonic;  ///< of the edges' stamps, and so of the forces': monotonic or realtime
};

/// At each data-ready edge of the gyroscope both dies are read. A rate carries the edge's stamp. The accelerometer runs
/// at 1600 Hz on its own clock; the 24-bit sensor time (39.0625 us), read with the data, gives their age: samples fall
/// on multiples of 16 ticks. The stamps of the two dies differ; ImuAssembler interpolates. Thread-bound.
class Bmi088 final : public SpiImuChip {
public:
    Bmi088(SpiDevice& gyro, SpiDevice& accelerometer, Clock& clock, const Bmi088Options& options)
        : gyro_(gyro), accel_(accelerometer, 1), clock_(clock), options_(options) {}

    Status configure(SelfTest test, std::string& problem) override;
    void close() override;
    Status read(const TriggerEdge& edge, SpiMeasurements& out) override;
    bool newest_edge_only() const override { return true; }
    std::string_view problem() const override { return problem_; }

private:
    Status start_accelerometer(SelfTest test, std::string& problem);
    Status start_gyro(SelfTest test, std::string& problem);
    Status test_accelerometer(std::string& problem);
    Status test_gyro(std::string& problem);
    Status read_force(SpiMeasurement& measurement);
    Status failed(SpiDevice& device);

    RegisterBus gyro_;
    RegisterBus accel_;
    Clock& clock_;
    Bmi088Options options_;
    std::string problem_;
    bool any_force_ = false;
    std::uint32_t sensor_time_ = 0;  ///< at the last read, ticks
    bool any_rate_ = false;
    std::uint32_t edge_sequence_ = 0;
    std::uint32_t reads_ = 0;
    double temperature_c_ = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace facet
