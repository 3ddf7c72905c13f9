// SPDX-License-Identifier: BSD-2-Clause
// A chip of the ADIS16 family made of its registers.
#pragma once

#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "drivers/imu_spi/adis16.h"
#include "tests/drivers/imu_spi/fake_spi.h"

namespace facet::test {

/// A chip of the family: 16-bit registers, burst read, checksum.
class FakeAdis final : public FakeSpiChip {
public:
    explicit FakeAdis(Adis16Model model) : variant_(adis16_variant(model)) { reset(); }

    std::array<std::int16_t, 7> data{};  ///< rates, forces, temperature
    std::uint16_t status = 0;
    std::uint16_t counter = 0;
    bool flip_a_bit = false;
    bool dead = false;
    bool failing_self_test = false;
    std::map<std::uint8_t, std::uint16_t> registers;

    void sample(std::int16_t value) {
        data = {value, static_cast<std::int16_t>(-value), 0, 0, value, 1200, 0};
        ++counter;
    }

private:
    void reset() {
        registers.clear();
        registers[variant_.is_16448 ? 0x56 : 0x72] = variant_.product_id;
        if (variant_.range_code >= 0) {
            registers[0x5E] = static_cast<std::uint16_t>(variant_.range_code << 2);
        }
    }
    void frame(const std::vector<std::uint8_t>& out, std::vector<std::uint8_t>& in) override {
        if (dead) {
            return;
        }
        if (out.size() > 2) {
            burst(in);
            return;
        }
        // The answer to the command of the frame before.
        in[0] = static_cast<std::uint8_t>(answer_ >> 8);
        in[1] = static_cast<std::uint8_t>(answer_ & 0xFF);
        const std::uint8_t address = out[0] & 0x7F;
        if ((out[0] & 0x80) == 0) {
            answer_ = registers[address & 0x7E];
            return;
        }
        std::uint16_t& word = registers[address & 0x7E];
        word =
            static_cast<std::uint16_t>((address & 1) != 0 ? (word & 0x00FF) | (out[1] << 8) : (word & 0xFF00) | out[1]);
        if ((address & 1) != 0) {
            command(address & 0x7E, word);
        }
    }
    void command(std::uint8_t address, std::uint16_t word) {
        const bool reset_command = address == (variant_.is_16448 ? 0x3E : 0x68) && (word & 0x80) != 0;
        const bool test_command =
            variant_.is_16448 ? address == 0x34 && (word & 0x400) != 0 : address == 0x68 && (word & 0x04) != 0;
        if (reset_command) {
            reset();
        }
        if (test_command) {
            registers[variant_.is_16448 ? 0x3C : 0x02] = failing_self_test ? 0x0820 : 0;
            registers[0x34] = 0;
        }
    }
    void burst(std::vector<std::uint8_t>& in) {
        std::vector<std::uint16_t> words{status};
        for (std::size_t i = 0; i < 6; ++i) {
            words.push_back(static_cast<std::uint16_t>(data[i]));
        }
        if (variant_.is_16448) {
            words.insert(words.end(), {1, 2, 3, 4});
        }
        words.push_back(static_cast<std::uint16_t>(data[6] & (variant_.is_16448 ? 0xFFF : 0xFFFF)));
        if (variant_.is_16448) {
            words.push_back(adis16448_crc(std::span(words).subspan(1)));
        } else {
            words.push_back(counter);
            words.push_back(adis1647x_checksum(words));
        }
        if (flip_a_bit) {
            words[3] ^= 0x10;
            flip_a_bit = false;
        }
        REQUIRE(in.size() == 2 + 2 * words.size());
        for (std::size_t i = 0; i < words.size(); ++i) {
            in[2 + 2 * i] = static_cast<std::uint8_t>(words[i] >> 8);
            in[3 + 2 * i] = static_cast<std::uint8_t>(words[i] & 0xFF);
        }
    }

    const Adis16Variant& variant_;
    std::uint16_t answer_ = 0;
};

}  // namespace facet::test
