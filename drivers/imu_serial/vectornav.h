// SPDX-License-Identifier: BSD-2-Clause
// VectorNav's binary output (VN-100, VN-200, VN-300).
#pragma once

#include "drivers/imu_serial/serial_protocol.h"

namespace facet {

/// 0xFA, a byte of groups, two bytes of fields for each group, their values in order (little-endian), a CRC of 16 bits
/// (polynomial 0x1021, begins at zero, high byte first) over all but the first byte [UM001, sections 3.8 and 4.3].
/// Rates and forces are the calibrated ones without the bias estimates of the sensor's own filter, which would step.
class VectorNav final : public SerialProtocol {
public:
    SerialFrame frame(std::span<const std::uint8_t> bytes) const override;
    void read(std::span<const std::uint8_t> packet, SerialReading& reading) override;
    void reset() override {}
    const char* outputs() const override {
        return "TimeStartup and Imu of group 1, or TimeStartup with UncompAccel and UncompGyro of group 3";
    }
};

}  // namespace facet
