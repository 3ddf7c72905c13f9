// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/imu_iio/scan_format.h"

#include <array>
#include <catch2/catch.hpp>
#include <random>
#include <string>
#include <vector>

namespace facet::scan_format_test {
namespace {

ScanType type_of(const std::string& text) {
    ScanType type;
    INFO(text);
    REQUIRE(ok(parse_scan_type(text, type)));
    return type;
}

std::int64_t value_of(const std::string& type, std::vector<std::uint8_t> bytes) {
    return read_scan_value(bytes, type_of(type));
}

TEST_CASE("types of scan elements are read as the kernel writes them") {
    const ScanType type = type_of("be:u12/16X2>>4\n");
    CHECK(type.is_big_endian);
    CHECK_FALSE(type.is_signed);
    CHECK(type.bits == 12);
    CHECK(type.storage_bits == 16);
    CHECK(type.repeat == 2);
    CHECK(type.shift == 4);
    CHECK(type.bytes() == 4);
    CHECK(type_of("le:s64/64>>0").bytes() == 8);
    CHECK(type_of("le:s32/32").shift == 0);
    CHECK(type_of("le:s8/8>>0").bytes() == 1);
}

TEST_CASE("a type of another form is refused and leaves the old one") {
    for (const char* text : {"",
                             "le",
                             "le:",
                             "xe:s16/16>>0",
                             "le:f32/32>>0",
                             "le:s16",
                             "le:s16/",
                             "le:s16/16>>",
                             "le:s16/16>0",
                             "le:s16/16X>>0",
                             "le:s16/16X0>>0",
                             "le:s16/16X3>>0",
                             "le:s0/16>>0",
                             "le:s17/16>>0",
                             "le:s12/16>>5",
                             "le:s16/24>>0",
                             "le:s16/4>>0",
                             "le:s16/128>>0",
                             "le:u64/64>>0",
                             "le:s16/16>>-1",
                             "le:s-16/16>>0",
                             "le:s16/16>>0 x",
                             "le:s99999999999/16>>0",
                             "LE:s16/16>>0"}) {
        INFO(text);
        ScanType type;
        type.bits = 7;
        CHECK(parse_scan_type(text, type) == Status::kInvalidArgument);
        CHECK(type.bits == 7);
    }
}

TEST_CASE("values are shifted, masked and signed, in both orders of bytes") {
    CHECK(value_of("le:s16/16>>0", {0x34, 0x12}) == 0x1234);
    CHECK(value_of("be:s16/16>>0", {0x12, 0x34}) == 0x1234);
    CHECK(value_of("le:s16/16>>0", {0xFF, 0xFF}) == -1);
    CHECK(value_of("le:u16/16>>0", {0xFF, 0xFF}) == 65535);
    CHECK(value_of("be:s12/16>>4", {0x80, 0x0F}) == -2048);
    CHECK(value_of("be:u12/16>>4", {0x80, 0x0F}) == 2048);
    // Bits above those that count are none of ours.
    CHECK(value_of("le:s12/16>>0", {0xFF, 0xF7}) == 2047);
    CHECK(value_of("le:s24/32>>8", {0xAA, 0xFE, 0xFF, 0xFF}) == -2);
    CHECK(value_of("be:s24/32>>0", {0xAA, 0x80, 0x00, 0x00}) == -8388608);
    CHECK(value_of("le:s8/8>>0", {0x80}) == -128);
    CHECK(value_of("le:s64/64>>0", {0xFE, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF}) == -2);
    CHECK(value_of("be:u63/64>>1", {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFE}) == INT64_MAX);
    // Of repeated values the first.
    CHECK(value_of("le:s16/16X2>>0", {0x01, 0x00, 0x02, 0x00}) == 1);
}

TEST_CASE("any value survives packing, whatever the format") {
    std::mt19937_64 random(3);
    for (int run = 0; run < 20'000; ++run) {
        ScanType type;
        type.is_big_endian = random() % 2 == 0;
        type.is_signed = random() % 2 == 0;
        type.storage_bits = 8 << (random() % 4);
        type.bits = 1 + static_cast<int>(random() % static_cast<unsigned>(type.storage_bits));
        type.bits -= type.bits == 64 && !type.is_signed ? 1 : 0;
        type.shift = static_cast<int>(random() % static_cast<unsigned>(type.storage_bits - type.bits + 1));
        const std::uint64_t mask = type.bits == 64 ? ~0ULL : (1ULL << static_cast<unsigned>(type.bits)) - 1;
        const std::uint64_t field = random() & mask;
        const bool is_negative = type.is_signed && ((field >> static_cast<unsigned>(type.bits - 1)) & 1) != 0;
        const auto expected = static_cast<std::int64_t>(is_negative ? field | ~mask : field);
        // Random bits everywhere else.
        const auto shift = static_cast<unsigned>(type.shift);
        const std::uint64_t stored = (random() & ~(mask << shift)) | (field << shift);
        std::vector<std::uint8_t> bytes(static_cast<std::size_t>(type.storage_bits / 8));
        for (std::size_t i = 0; i < bytes.size(); ++i) {
            const std::size_t byte = type.is_big_endian ? bytes.size() - 1 - i : i;
            bytes[i] = static_cast<std::uint8_t>(stored >> (8 * byte));
        }
        REQUIRE(read_scan_value(bytes, type) == expected);
    }
}

TEST_CASE("elements lie in the order of their indices, each aligned to its size") {
    // Three of 16 bits, a stamp after them, and one of 32 that comes before all others.
    std::array<ScanElement, 5> elements{{{9, type_of("le:s64/64>>0"), 0},
                                         {2, type_of("le:s16/16>>0"), 0},
                                         {1, type_of("le:s16/16>>0"), 0},
                                         {0, type_of("be:u24/32>>8"), 0},
                                         {3, type_of("le:s16/16>>0"), 0}}};
    std::size_t size = 0;
    REQUIRE(ok(lay_out_scan(elements, size)));
    CHECK(size == 24);
    const std::array<std::size_t, 5> offsets{0, 4, 6, 8, 16};
    const std::array<int, 5> indices{0, 1, 2, 3, 9};
    for (std::size_t i = 0; i < elements.size(); ++i) {
        CHECK(elements[i].index == indices[i]);
        CHECK(elements[i].offset == offsets[i]);
    }
    // The end is padded for the next scan.
    std::array<ScanElement, 2> odd{{{0, type_of("le:s32/32>>0"), 0}, {1, type_of("le:s8/8>>0"), 0}}};
    REQUIRE(ok(lay_out_scan(odd, size)));
    CHECK(size == 8);
    // Repeated values are aligned as a whole.
    std::array<ScanElement, 2> repeated{{{0, type_of("le:s8/8>>0"), 0}, {1, type_of("le:s16/16X4>>0"), 0}}};
    REQUIRE(ok(lay_out_scan(repeated, size)));
    CHECK(repeated[1].offset == 8);
    CHECK(size == 16);
}

TEST_CASE("scans that cannot be are refused") {
    std::size_t size = 7;
    CHECK(lay_out_scan({}, size) == Status::kInvalidArgument);
    std::array<ScanElement, 2> twins{{{4, type_of("le:s16/16>>0"), 0}, {4, type_of("le:s16/16>>0"), 0}}};
    CHECK(lay_out_scan(twins, size) == Status::kInvalidArgument);
    std::array<ScanElement, 2> large{{{0, type_of("le:s64/64X16>>0"), 0}, {1, type_of("le:s8/8>>0"), 0}}};
    CHECK(lay_out_scan(large, size) == Status::kInvalidArgument);
    CHECK(size == 7);
}

}  // namespace
}  // namespace facet::scan_format_test
