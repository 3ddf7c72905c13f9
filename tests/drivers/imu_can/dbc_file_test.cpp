// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/imu_can/dbc_file.h"

#include <array>
#include <catch2/catch.hpp>
#include <cstring>
#include <random>

namespace facet::dbc_file_test {
namespace {

DbcFile parse(const std::string& text) {
    DbcFile file;
    std::string error;
    const Status status = file.parse(text, "a.dbc", error);
    INFO(error);
    REQUIRE(status == Status::kOk);
    return file;
}

std::string error_of(const std::string& text) {
    DbcFile file;
    std::string error;
    REQUIRE(file.parse(text, "a.dbc", error) == Status::kInvalidArgument);
    return error;
}

DbcSignal signal(int start, int length, bool little_endian, bool is_signed) {
    DbcSignal s;
    s.start_bit = start;
    s.length = length;
    s.little_endian = little_endian;
    s.is_signed = is_signed;
    return s;
}

constexpr const char* kWhole = R"dbc(VERSION "1.0"

NS_ :
	NS_DESC_
	CM_
	BA_DEF_

	SG_MUL_VAL_

BS_:

BU_: IMU ECU

VAL_TABLE_ Modes 0 "off" 1 "on; still \"on\"" ;

BO_ 256 Motion: 8 IMU
 SG_ Rate : 0|16@1- (0.01,0) [-300|300] "deg/s"  ECU
 SG_ Force : 23|16@0- (0.001,-1.5) [0|0] "g" ECU,IMU
 SG_ Count : 60|4@1+ (1,0) [0|15] "" Vector__XXX

BO_ 2566844926 Muxed: 8 IMU
 SG_ Page M : 0|8@1+ (1,0) [0|0] "" ECU
 SG_ A m0 : 8|16@1+ (1,0) [0|0] "" ECU
 SG_ B m1 : 8|32@1- (1,0) [0|0] "" ECU

BO_ 3221225472 VECTOR__INDEPENDENT_SIG_MSG: 0 Vector__XXX
 SG_ Nowhere : 0|8@1+ (1,0) [0|0] "" Vector__XXX

CM_ SG_ 256 Rate "about z;
in two lines";
BA_DEF_ BO_  "Period" INT 0 1000;
SIG_VALTYPE_ 2566844926 B : 1;
)dbc";

TEST_CASE("a database with everything that files have is read") {
    const DbcFile file = parse(kWhole);
    REQUIRE(file.messages().size() == 2);
    const DbcMessage* const motion = file.find("Motion");
    REQUIRE(motion != nullptr);
    CHECK(motion->id == 256);
    CHECK_FALSE(motion->extended);
    CHECK(motion->length == 8);
    REQUIRE(motion->signals.size() == 3);
    const DbcSignal& force = *motion->find("Force");
    CHECK(force.start_bit == 23);
    CHECK(force.length == 16);
    CHECK_FALSE(force.little_endian);
    CHECK(force.is_signed);
    CHECK(force.scale == 0.001);
    CHECK(force.offset == -1.5);
    CHECK(force.unit == "g");
    const DbcMessage* const muxed = file.find("Muxed");
    REQUIRE(muxed != nullptr);
    CHECK(muxed->extended);
    CHECK(muxed->id == 0x18FEF1FE);
    CHECK(muxed->find("Page")->multiplex == DbcSignal::Multiplex::kSwitch);
    CHECK(muxed->find("B")->multiplex_value == 1);
    CHECK(muxed->find("B")->number == DbcSignal::Number::kFloat32);
    CHECK(file.find("Nowhere") == nullptr);
    // The same with the line ends of Windows and a byte order mark.
    std::string windows = "\xEF\xBB\xBF";
    for (const char c : std::string(kWhole)) {
        windows += c == '\n' ? std::string("\r\n") : std::string(1, c);
    }
    CHECK(parse(windows).messages().size() == 2);
}

TEST_CASE("values: both byte orders, sign, scale, range, multiplexing, floats") {
    const DbcFile file = parse(kWhole);
    const DbcMessage& motion = *file.find("Motion");
    // Worked by hand: 0xFF38 = -200 -> -2 deg/s; bytes 2, 3 big-endian 0x0BB8 = 3000 -> 1.5 g; high nibble of byte 7.
    const std::array<std::uint8_t, 8> data{0x38, 0xFF, 0x0B, 0xB8, 0, 0, 0, 0xA0};
    CHECK(motion.value(*motion.find("Rate"), data).value() == Approx(-2.0).epsilon(1e-15));
    CHECK(motion.value(*motion.find("Force"), data).value() == Approx(1.5).epsilon(1e-15));
    CHECK(motion.value(*motion.find("Count"), data).value() == 10.0);
    const std::array<std::uint8_t, 8> beyond{0x31, 0x75};  // 30001 -> 300.01 deg/s
    CHECK(motion.value(*motion.find("Rate"), beyond).status() == Status::kCorrupt);
    CHECK(motion.value(*motion.find("Rate"), std::span(data).first(1)).status() == Status::kCorrupt);

    const DbcMessage& muxed = *file.find("Muxed");
    const std::array<std::uint8_t, 8> page1{1, 0x00, 0x00, 0xC0, 0x3F};  // 1.5F
    CHECK(muxed.value(*muxed.find("B"), page1).value() == 1.5);
    CHECK(muxed.value(*muxed.find("A"), page1).status() == Status::kNotFound);
    const std::array<std::uint8_t, 8> infinite{1, 0x00, 0x00, 0x80, 0x7F};
    CHECK(muxed.value(*muxed.find("B"), infinite).status() == Status::kCorrupt);
}

TEST_CASE("raw bits agree with a model that writes them, in any place, length and order") {
    std::mt19937_64 random(3);  // NOLINT(cert-msc51-cpp): fixed on purpose
    int tried = 0;
    while (tried < 5000) {
        DbcSignal s = signal(static_cast<int>(random() % 64), static_cast<int>(1 + random() % 64), random() % 2 == 0,
                             random() % 2 == 0);
        if (s.bytes_needed() > 8) {
            continue;
        }
        ++tried;
        std::array<std::uint8_t, 8> data{};
        const std::uint64_t all = random();
        std::memcpy(data.data(), &all, 8);
        // Model: the whole frame as one 64-bit number, little-endian or big-endian; a signal is then contiguous.
        std::uint64_t number = 0;
        int lowest = s.start_bit;
        for (std::size_t i = 0; i < 8; ++i) {
            number |= static_cast<std::uint64_t>(data[s.little_endian ? i : 7 - i]) << (8 * i);
        }
        if (!s.little_endian) {
            const int highest = 8 * (7 - s.start_bit / 8) + s.start_bit % 8;
            lowest = highest - s.length + 1;
            REQUIRE(lowest >= 0);
        }
        const std::uint64_t mask = s.length == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << s.length) - 1;
        REQUIRE(s.raw(data) == ((number >> lowest) & mask));
    }
}

TEST_CASE("each error names the line and what is wrong") {
    const std::string head = "VERSION \"\"\nBO_ 1 M: 8 N\n";
    CHECK(error_of("HELLO 3") == "a.dbc:1: unknown statement 'HELLO'");
    CHECK(error_of("VERSION \"\"\n\nSG_ x : 0|1@1+ (1,0) [0|0] \"\" N\n") == "a.dbc:3: SG_ before any BO_");
    CHECK(error_of(head + " SG_ x : 0|0@1+ (1,0) [0|0] \"\" N\n") ==
          "a.dbc:3: signal x has an impossible place or length");
    CHECK(error_of(head + " SG_ x : 60|8@1+ (1,0) [0|0] \"\" N\n") == "a.dbc:3: signal x does not fit into message M");
    CHECK(error_of(head + " SG_ x : 56|16@0+ (1,0) [0|0] \"\" N\n") == "a.dbc:3: signal x does not fit into message M");
    CHECK(error_of(head + " SG_ x : 0|8@2+ (1,0) [0|0] \"\" N\n") ==
          "a.dbc:3: expected 'start|length@order' in signal x");
    CHECK(error_of(head + " SG_ x : 0|8@1 (1,0) [0|0] \"\" N\n") ==
          "a.dbc:3: expected + or - after the byte order of signal x");
    CHECK(error_of(head + " SG_ x : 0|8@1+ (nan,0) [0|0] \"\" N\n") ==
          "a.dbc:3: expected (scale,offset) [min|max] \"unit\" in signal x");
    CHECK(error_of(head + " SG_ x : 0|8@1+ (0,0) [0|0] \"\" N\n") == "a.dbc:3: signal x has a scale of 0");
    CHECK(error_of(head + " SG_ x m0M : 0|8@1+ (1,0) [0|0] \"\" N\n") ==
          "a.dbc:3: extended multiplexing ('m0M') is not supported");
    CHECK(error_of(head + " SG_ x q : 0|8@1+ (1,0) [0|0] \"\" N\n") ==
          "a.dbc:3: 'q' is not a multiplexer mark (M or m<number>)");
    CHECK(error_of(head + "BO_ 2 M: 8 N\n") == "a.dbc:3: message M has the name or identifier of another message");
    CHECK(error_of("BO_ 2048 M: 8 N\n") == "a.dbc:1: identifier 2048 of message M is out of range");
    CHECK(error_of("BO_ 1 M: 65 N\n") == "a.dbc:1: message M is longer than 64 bytes");
    CHECK(error_of(head + "CM_ \"never ends;\n") == "a.dbc:3: no ';' at the end of CM_");
    CHECK(error_of(head + "SIG_VALTYPE_ 1 x : 1;") == "a.dbc:3: SIG_VALTYPE_ of the unknown signal x");
    CHECK(error_of(head + "SG_MUL_VAL_ 1 a b 0-0;") == "a.dbc:3: extended multiplexing (SG_MUL_VAL_) is not supported");
}

TEST_CASE("a damaged file never crashes the reader, and a failed parse keeps the old content") {
    std::mt19937 random(5);  // NOLINT(cert-msc51-cpp): fixed on purpose
    DbcFile file = parse(kWhole);
    const std::string whole = kWhole;
    int refused = 0;
    for (int i = 0; i < 3000; ++i) {
        std::string damaged = whole;
        for (int k = 0; k < 3; ++k) {
            damaged[random() % damaged.size()] = static_cast<char>(random() % 256);
        }
        damaged.resize(random() % damaged.size());
        DbcFile other;
        std::string error;
        refused += ok(other.parse(damaged, "d", error)) ? 0 : 1;
    }
    CHECK(refused > 500);
    std::string error;
    CHECK(file.parse("X", "x", error) == Status::kInvalidArgument);
    CHECK(file.messages().size() == 2);
}

}  // namespace
}  // namespace facet::dbc_file_test
