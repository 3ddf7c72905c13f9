// SPDX-License-Identifier: BSD-2-Clause
// Xsens' MTData2 (MTi 1, 10, 100 and 600 series).
#pragma once

#include "drivers/imu_serial/serial_protocol.h"

namespace facet {

/// 0xFA, 0xFF, an identifier, a length (0xFF: two bytes of it follow), data, and a byte that makes the sum of all but
/// the first byte zero. The data of MTData2 (0x36) are items of identifier, length and value, big-endian [MT0101P].
/// SampleTimeFine counts 0.1 ms in 32 bits and is carried on over its end.
class Xsens final : public SerialProtocol {
public:
    SerialFrame frame(std::span<const std::uint8_t> bytes) const override;
    void read(std::span<const std::uint8_t> packet, SerialReading& reading) override;
    void reset() override { *this = {}; }
    const char* outputs() const override {
        return "SampleTimeFine, Acceleration and RateOfTurn, in MTData2, as float, double or fixed point 12.20";
    }

private:
    void read_item(unsigned identifier, std::span<const std::uint8_t> value, SerialReading& reading);

    bool any_time_ = false;
    std::uint32_t ticks_ = 0;  ///< of the newest SampleTimeFine
    std::int64_t time_ns_ = 0;
    bool any_count_ = false;
    std::uint16_t count_ = 0;
};

}  // namespace facet
