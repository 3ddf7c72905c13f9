// SPDX-License-Identifier: BSD-2-Clause
// Analog Devices ADIS16448 and the ADIS16470/16475 family.
#pragma once

#include <array>
#include <cstdint>

#include "drivers/imu_spi/spi_device.h"
#include "drivers/imu_spi/spi_imu_chip.h"
#include "platform/port/clock.h"

namespace facet {

/// What differs between the members of the family; the table in adis16.cpp names its sources.
struct Adis16Variant {
    const char* name;
    std::uint16_t product_id;
    double rate_scale;   ///< rad/s per LSB
    double force_scale;  ///< m/s^2 per LSB
    double temperature_scale;
    double temperature_offset;
    double internal_rate_hz;  ///< of the chip's own clock
    bool is_16448;            ///< CRC-16 and no counter, instead of a byte sum and a counter
    int range_code;           ///< content of RANG_MDL[3:2] that it must have; -1 if there is no such register
};

enum class Adis16Model : std::uint8_t { k16448, k16470, k16475Dash1, k16475Dash2, k16475Dash3 };
const Adis16Variant& adis16_variant(Adis16Model model);

struct Adis16Options {
    Adis16Model model = Adis16Model::k16448;
    /// ADIS16448: rate = 819.2 Hz / 2^d. Others: 2000 Hz / (d + 1).
    std::uint16_t decimation = 2;
    bool self_test = true;
};

/// CRC of the ADIS16448's burst: polynomial 0x1021 applied to the least significant bit first, initial 0xFFFF, words
/// from XGYRO_OUT to TEMP_OUT, their low bytes first, inverted and byte-swapped at the end.
std::uint16_t adis16448_crc(std::span<const std::uint16_t> words);
/// Sum of all bytes of the words from DIAG_STAT to DATA_CNTR.
std::uint16_t adis1647x_checksum(std::span<const std::uint16_t> words);

/// Burst read after each data-ready edge. A wrong checksum, a failure flag or an empty bus drops the sample (kCorrupt).
/// The counter, where there is one, reveals lost and repeated samples, and whether a read was so late that it got the
/// next sample instead: then the stamp is advanced by a period. Thread-bound.
class Adis16 final : public SpiImuChip {
public:
    Adis16(SpiDevice& bus, Clock& clock, const Adis16Options& options)
        : bus_(bus), clock_(clock), options_(options), variant_(adis16_variant(options.model)) {}

    Status configure(SelfTest test, std::string& problem) override;
    void close() override { bus_.close(); }
    Status read(const TriggerEdge& edge, SpiMeasurements& out) override;
    bool newest_edge_only() const override { return true; }
    std::string_view problem() const override { return bus_.problem(); }

    double rate_hz() const;

private:
    static constexpr std::size_t kMaxWords = 13;
    using Words = std::array<std::uint16_t, kMaxWords>;

    Status read_register(std::uint8_t address, std::uint16_t& value);
    Status write_register(std::uint8_t address, std::uint16_t value);
    Status write_checked(std::uint8_t address, std::uint16_t value);
    Status reset_and_identify(std::string& problem);
    Status self_test(std::string& problem);
    Status set_up(std::string& problem);
    Status burst(Words& words);
    bool intact(const Words& words) const;
    Status count(const Words& words, const TriggerEdge& edge, SpiMeasurement& measurement);

    SpiDevice& bus_;
    Clock& clock_;
    Adis16Options options_;
    const Adis16Variant& variant_;
    bool any_read_ = false;
    std::uint16_t counter_ = 0;
    std::uint32_t edge_sequence_ = 0;
    Timestamp last_stamp_;  ///< of the last sample
};

}  // namespace facet
