// SPDX-License-Identifier: BSD-2-Clause
// MicroStrain's MIP (3DM-GX5, CX5, CV5, GV7, CV7, GQ7).
#pragma once

#include "drivers/imu_serial/serial_protocol.h"

namespace facet {

/// 0x75, 0x65, a descriptor set, a length, fields of length, descriptor and value, big-endian, and Fletcher's checksum
/// of all before it. Of set 0x80: scaled acceleration (g) and rate; the time is that of the reference clock, of older
/// sensors the time of the week, which begins again each week [MIP packet overview, data set 0x80].
class MicroStrain final : public SerialProtocol {
public:
    SerialFrame frame(std::span<const std::uint8_t> bytes) const override;
    void read(std::span<const std::uint8_t> packet, SerialReading& reading) override;
    void reset() override {}
    const char* outputs() const override {
        return "scaled accelerometer (0x04), scaled gyroscope (0x05) and a time stamp (0xD5, 0xD3 or 0x12) of set 0x80";
    }
};

}  // namespace facet
