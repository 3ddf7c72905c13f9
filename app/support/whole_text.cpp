// SPDX-License-Identifier: BSD-2-Clause
#include "app/support/whole_text.h"

#include <cstdint>
#include <fstream>
#include <iterator>

#include "app/support/input_error.h"
#include "platform/base/regular_file.h"

namespace facet {
namespace {

constexpr std::uintmax_t kMostTextBytes = 4U << 20U;  // a thousand times what such a file has

/// @param low  which byte of each two is the lower one
std::string ascii_of_utf16(const std::string& text, std::size_t low) {
    std::string ascii;
    for (std::size_t i = 2; i + 1 < text.size(); i += 2) {
        const char lower = text[i + low];
        const bool is_ascii = text[i + 1 - low] == '\0' && (static_cast<unsigned char>(lower) & 0x80U) == 0U;
        ascii += is_ascii ? lower : '?';
    }
    return ascii;
}

}  // namespace

std::string read_whole_text(const std::string& path) {
    if (const std::string refusal = refuse_file(path, kMostTextBytes); !refusal.empty()) {
        throw InputError(path + ": " + refusal);
    }
    std::ifstream stream(path, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    if (!stream.is_open() || stream.bad()) {
        throw InputError(path + ": cannot be read");
    }
    if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF")) {
        return ascii_of_utf16(text, text.front() == '\xFF' ? 0 : 1);
    }
    return text.starts_with("\xEF\xBB\xBF") ? text.substr(3) : text;
}

}  // namespace facet
