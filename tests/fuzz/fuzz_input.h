// SPDX-License-Identifier: BSD-2-Clause
// Bytes of a fuzzer as what programs read: numbers, and files.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

namespace facet::test {

/// Takes values from the front of the bytes; zeros once they are used up.
class FuzzInput {
public:
    FuzzInput(const std::uint8_t* data, std::size_t size) : bytes_(data, size) {}

    bool empty() const { return bytes_.empty(); }

    template <class T>
    requires std::is_trivially_copyable_v<T> T take() {
        T value{};
        const std::size_t size = std::min(sizeof(T), bytes_.size());
        std::memcpy(&value, bytes_.data(), size);
        bytes_ = bytes_.subspan(size);
        return value;
    }

    std::span<const std::uint8_t> take_bytes(std::size_t most) {
        const auto taken = bytes_.first(std::min(most, bytes_.size()));
        bytes_ = bytes_.subspan(taken.size());
        return taken;
    }
    std::span<const std::uint8_t> take_rest() { return take_bytes(bytes_.size()); }
    std::string_view rest_as_text() {
        const auto rest = take_rest();
        return {reinterpret_cast<const char*>(rest.data()), rest.size()};
    }

private:
    std::span<const std::uint8_t> bytes_;
};

/// A regular file in memory with this content, under a path that can be opened, as long as the object lives.
class MemoryFile {
public:
    explicit MemoryFile(std::span<const std::uint8_t> content);
    ~MemoryFile();
    MemoryFile(const MemoryFile&) = delete;
    MemoryFile& operator=(const MemoryFile&) = delete;

    const std::string& path() const { return path_; }

private:
    int descriptor_;
    std::string path_;
};

/// Ends the program, which a fuzzer reports with the input that led there, unless a promise is kept.
inline void require(bool is_kept) {
    if (!is_kept) {
        __builtin_trap();
    }
}

}  // namespace facet::test

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
