// SPDX-License-Identifier: BSD-2-Clause
// Little-endian numbers and texts in bytes whose lengths nobody has checked yet.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

namespace facet {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they lie in the file");

/// Takes values from the front. What is not there any more is zero or empty, and failed() from then on. Reentrant.
class ByteReader {
public:
    explicit ByteReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

    bool failed() const { return failed_; }
    std::size_t left() const { return bytes_.size(); }

    template <class T>
    requires std::is_arithmetic_v<T> T take() {
        T value{};
        const std::span<const std::uint8_t> taken = take_bytes(sizeof(T));
        if (!failed_) {
            std::memcpy(&value, taken.data(), sizeof(T));
        }
        return value;
    }
    std::span<const std::uint8_t> take_bytes(std::uint64_t count) {
        if (failed_ || count > bytes_.size()) {
            failed_ = true;
            bytes_ = {};
            return {};
        }
        const auto taken = bytes_.first(static_cast<std::size_t>(count));
        bytes_ = bytes_.subspan(taken.size());
        return taken;
    }
    /// Bytes behind a count of 32 bits.
    std::span<const std::uint8_t> take_counted() { return take_bytes(take<std::uint32_t>()); }
    std::string_view take_text() {
        const auto taken = take_counted();
        return {reinterpret_cast<const char*>(taken.data()), taken.size()};
    }

private:
    std::span<const std::uint8_t> bytes_;
    bool failed_ = false;
};

inline std::span<const std::uint8_t> bytes_of(std::string_view text) {
    return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}
inline std::string_view text_of(std::span<const std::uint8_t> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

template <class T>
requires std::is_arithmetic_v<T>
void put(std::string& out, T value) {
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    out.append(bytes, sizeof(T));
}
/// Behind its length in 32 bits.
inline void put_text(std::string& out, std::string_view text) {
    put(out, static_cast<std::uint32_t>(text.size()));
    out += text;
}

}  // namespace facet
