// SPDX-License-Identifier: BSD-2-Clause
// Reads CAN databases (DBC): the layout of signals in frames.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "platform/base/result.h"
#include "platform/base/status.h"

namespace facet {

/// One signal of a message: value = scale * raw + offset. Bits are numbered as DBC does: bit b of byte n is 8 n + b.
struct DbcSignal {
    enum class Multiplex : std::uint8_t { kNone, kSwitch, kValue };
    enum class Number : std::uint8_t { kInteger, kFloat32, kFloat64 };

    std::string name;
    int start_bit = 0;  ///< of the least significant bit if little-endian ("@1"), else of the most significant one
    int length = 0;     ///< bits, 1 to 64
    bool little_endian = true;  ///< Intel ("@1"); else Motorola ("@0")
    bool is_signed = false;
    Number number = Number::kInteger;
    double scale = 1.0;
    double offset = 0.0;
    double min = 0.0;  ///< allowed range of the value if min < max, else anything
    double max = 0.0;
    std::string unit;
    Multiplex multiplex = Multiplex::kNone;
    std::uint64_t multiplex_value = 0;  ///< of the switch, with which a kValue signal is there

    /// The raw bits, right-aligned. Contract: they lie within data.
    std::uint64_t raw(std::span<const std::uint8_t> data) const;
    /// Bytes of a frame that the signal needs.
    int bytes_needed() const;
};

struct DbcMessage {
    std::uint32_t id = 0;  ///< 11 or 29 bits
    bool extended = false;
    std::string name;
    int length = 0;  ///< bytes, 0 to 64
    std::vector<DbcSignal> signals;

    const DbcSignal* find(std::string_view signal) const;
    /// Value of a signal of this message in a frame's data.
    /// @return kNotFound if the signal is multiplexed and not in this frame; kCorrupt if the frame is too short, or the
    ///         value is outside of its range or not finite.
    Result<double> value(const DbcSignal& signal, std::span<const std::uint8_t> data) const;
};

/// A parsed database. BO_, SG_ and SIG_VALTYPE_ are read, all other statements are skipped. Extended
/// multiplexing (SG_MUL_VAL_, "m0M") is refused. Thread-bound. Heap in parse.
class DbcFile {
public:
    /// @param name   of the file, for errors
    /// @param error  "name:line: what is wrong" on failure
    /// @return kInvalidArgument; the previous content is kept.
    Status parse(std::string_view text, std::string_view name, std::string& error);

    const DbcMessage* find(std::string_view message) const;
    const std::vector<DbcMessage>& messages() const { return messages_; }

private:
    std::vector<DbcMessage> messages_;
};

}  // namespace facet
