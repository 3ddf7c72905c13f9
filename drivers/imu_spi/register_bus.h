// SPDX-License-Identifier: BSD-2-Clause
// Byte registers behind an address byte whose top bit says "read": ICM-42688-P and BMI088.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "drivers/imu_spi/spi_device.h"

namespace facet {

/// Thread-bound. No heap.
class RegisterBus {
public:
    /// @param dummy_bytes  that come between the address and the data of a read
    explicit RegisterBus(SpiDevice& bus, std::size_t dummy_bytes = 0) : bus_(bus), dummy_bytes_(dummy_bytes) {}

    SpiDevice& device() const { return bus_; }

    /// Reads consecutive registers in one transaction.
    Status read(std::uint8_t address, std::span<std::uint8_t> values) {
        const std::uint8_t command = kRead | address;
        const std::array<SpiSegment, 3> all{{{&command, nullptr, 1, 0, false},
                                             {nullptr, nullptr, dummy_bytes_, 0, false},
                                             {nullptr, values.data(), values.size(), 0, false}}};
        if (dummy_bytes_ == 0) {
            const std::array<SpiSegment, 2> without{all[0], all[2]};
            return bus_.transfer(without);
        }
        return bus_.transfer(all);
    }
    Status read(std::uint8_t address, std::uint8_t& value) { return read(address, std::span(&value, 1)); }

    Status write(std::uint8_t address, std::uint8_t value) {
        const std::array<std::uint8_t, 2> out{address, value};
        const SpiSegment segment{out.data(), nullptr, out.size(), 0, false};
        return bus_.transfer(std::span(&segment, 1));
    }

private:
    static constexpr std::uint8_t kRead = 0x80;

    SpiDevice& bus_;
    std::size_t dummy_bytes_;
};

}  // namespace facet
