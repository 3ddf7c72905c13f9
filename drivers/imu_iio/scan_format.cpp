// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/imu_iio/scan_format.h"

#include <algorithm>
#include <bit>
#include <charconv>

#include "platform/base/assert.h"

namespace facet {
namespace {

/// Takes parts from the front of a text.
class TypeReader {
public:
    explicit TypeReader(std::string_view text) : rest_(text) {}

    bool take(std::string_view word) {
        if (!rest_.starts_with(word)) {
            return false;
        }
        rest_.remove_prefix(word.size());
        return true;
    }
    /// A number within [0, 64].
    bool take(int& number) {
        int value = 0;
        const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), value);
        if (error != std::errc{} || value < 0 || value > 64) {
            return false;
        }
        rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
        number = value;
        return true;
    }
    /// Both, or neither if the word is not there. @return false if the number is missing
    bool take_optional(std::string_view word, int& number) { return !take(word) || take(number); }
    bool is_at_end() const { return rest_.find_first_not_of(" \n") == std::string_view::npos; }

private:
    std::string_view rest_;
};

bool is_power_of_two(int number) { return number > 0 && std::has_single_bit(static_cast<unsigned>(number)); }

bool is_possible(const ScanType& type) {
    return type.storage_bits >= 8 && is_power_of_two(type.storage_bits) && is_power_of_two(type.repeat) &&
           type.bits >= 1 && type.bits + type.shift <= type.storage_bits && (type.is_signed || type.bits < 64);
}

std::size_t aligned(std::size_t offset, std::size_t size) { return (offset + size - 1) / size * size; }

}  // namespace

Status parse_scan_type(std::string_view text, ScanType& type) {
    TypeReader reader(text);
    ScanType read;
    read.is_big_endian = reader.take("be:");
    if (!read.is_big_endian && !reader.take("le:")) {
        return Status::kInvalidArgument;
    }
    read.is_signed = reader.take("s");
    if (!read.is_signed && !reader.take("u")) {
        return Status::kInvalidArgument;
    }
    const bool is_read = reader.take(read.bits) && reader.take("/") && reader.take(read.storage_bits) &&
                         reader.take_optional("X", read.repeat) && reader.take_optional(">>", read.shift);
    if (!is_read || !reader.is_at_end() || !is_possible(read)) {
        return Status::kInvalidArgument;
    }
    type = read;
    return Status::kOk;
}

std::int64_t read_scan_value(std::span<const std::uint8_t> bytes, const ScanType& type) {
    const auto size = static_cast<std::size_t>(type.storage_bits / 8);
    FACET_ASSERT(bytes.size() >= size);
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < size; ++i) {
        value = (value << 8U) | bytes[type.is_big_endian ? i : size - 1 - i];
    }
    // The bits that count go to the top, and from there down with the sign or with zeros.
    value <<= static_cast<unsigned>(64 - type.shift - type.bits);
    const auto down = static_cast<unsigned>(64 - type.bits);
    return type.is_signed ? static_cast<std::int64_t>(value) >> down : static_cast<std::int64_t>(value >> down);
}

Status lay_out_scan(std::span<ScanElement> elements, std::size_t& scan_bytes) {
    std::ranges::sort(elements, {}, &ScanElement::index);
    const auto twin = std::ranges::adjacent_find(elements, {}, &ScanElement::index);
    if (elements.empty() || twin != elements.end()) {
        return Status::kInvalidArgument;
    }
    std::size_t end = 0;
    std::size_t largest = 1;
    for (ScanElement& element : elements) {
        const std::size_t size = element.type.bytes();
        element.offset = aligned(end, size);
        end = element.offset + size;
        largest = std::max(largest, size);
    }
    if (aligned(end, largest) > kMaxScanBytes) {
        return Status::kInvalidArgument;
    }
    scan_bytes = aligned(end, largest);
    return Status::kOk;
}

}  // namespace facet
