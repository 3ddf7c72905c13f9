// SPDX-License-Identifier: BSD-2-Clause
#include "app/mcap/json_fields.h"

#include <algorithm>
#include <array>

namespace facet {
namespace {

constexpr std::string_view kBlank = " \t\r\n";
constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
constexpr std::uint8_t kNoDigit = 64;

constexpr std::array<std::uint8_t, 256> values_of_digits() {
    std::array<std::uint8_t, 256> values{};
    values.fill(kNoDigit);
    for (std::size_t i = 0; i < kDigits.size(); ++i) {
        values[static_cast<std::uint8_t>(kDigits[i])] = static_cast<std::uint8_t>(i);
    }
    return values;
}
constexpr std::array<std::uint8_t, 256> kValues = values_of_digits();

/// Walks over a text; once it is not JSON it is at its end.
class JsonCursor {
public:
    explicit JsonCursor(std::string_view text) : text_(text) {}

    void skip_blanks() { at_ = std::min(text_.find_first_not_of(kBlank, at_), text_.size()); }
    bool take(char c) {
        skip_blanks();
        if (at_ < text_.size() && text_[at_] == c) {
            ++at_;
            return true;
        }
        return false;
    }
    /// The next value as it stands; empty if there is none.
    std::string_view take_value() {
        skip_blanks();
        const std::size_t begin = at_;
        const char first = at_ < text_.size() ? text_[at_] : '\0';
        const bool found = first == '"' ? skip_string() : first == '{' || first == '[' ? skip_nested() : skip_word();
        return found ? text_.substr(begin, at_ - begin) : fail();
    }

private:
    std::string_view fail() {
        at_ = text_.size();
        return {};
    }
    bool skip_string() {
        for (++at_;;) {
            at_ = text_.find_first_of("\"\\", at_);
            if (at_ >= text_.size()) {
                return false;
            }
            if (text_[at_++] == '"') {
                return true;
            }
            ++at_;  // what is escaped
        }
    }
    bool skip_nested() {
        std::size_t depth = 0;
        while (at_ < text_.size()) {
            switch (text_[at_]) {
                case '"':
                    if (!skip_string()) {
                        return false;
                    }
                    continue;
                case '{':
                case '[': ++depth; break;
                case '}':
                case ']': --depth; break;
                default: break;
            }
            ++at_;
            if (depth == 0) {
                return true;
            }
        }
        return false;
    }
    bool skip_word() {
        const std::size_t begin = at_;
        at_ = std::min(text_.find_first_of(",}] \t\r\n", at_), text_.size());
        return at_ > begin;
    }

    std::string_view text_;
    std::size_t at_ = 0;
};

std::size_t count_digits(std::string_view& text) {
    const std::size_t count = std::min(text.find_first_not_of("0123456789"), text.size());
    text.remove_prefix(count);
    return count;
}

}  // namespace

std::optional<std::string_view> json_member(std::string_view object, std::string_view name) {
    JsonCursor cursor(object);
    if (!cursor.take('{')) {
        return std::nullopt;
    }
    do {
        const std::string_view key = cursor.take_value();
        if (key.size() < 2 || key.front() != '"' || !cursor.take(':')) {
            return std::nullopt;
        }
        const std::string_view value = cursor.take_value();
        if (value.empty()) {
            return std::nullopt;
        }
        if (key.substr(1, key.size() - 2) == name) {
            return value;
        }
    } while (cursor.take(','));
    return std::nullopt;
}

bool is_json_number(std::string_view text) {
    if (text.starts_with('-')) {
        text.remove_prefix(1);
    }
    const bool leads_with_zero = text.starts_with('0');
    const std::size_t whole = count_digits(text);
    if (whole == 0 || (leads_with_zero && whole > 1)) {
        return false;
    }
    if (text.starts_with('.')) {
        text.remove_prefix(1);
        if (count_digits(text) == 0) {
            return false;
        }
    }
    if (text.starts_with('e') || text.starts_with('E')) {
        text.remove_prefix(1);
        if (text.starts_with('+') || text.starts_with('-')) {
            text.remove_prefix(1);
        }
        if (count_digits(text) == 0) {
            return false;
        }
    }
    return text.empty();
}

std::optional<std::string_view> json_plain_text(std::string_view value) {
    if (value.size() < 2 || value.front() != '"' || value.find('\\') != std::string_view::npos) {
        return std::nullopt;
    }
    return value.substr(1, value.size() - 2);
}

void append_base64(std::span<const std::uint8_t> bytes, std::string& out) {
    const std::size_t begin = out.size();
    out.resize(begin + (bytes.size() + 2) / 3 * 4, '=');
    char* to = out.data() + begin;
    std::size_t i = 0;
    for (; i + 2 < bytes.size(); i += 3) {
        const unsigned word = bytes[i] << 16U | bytes[i + 1] << 8U | bytes[i + 2];
        *to++ = kDigits[word >> 18U];
        *to++ = kDigits[word >> 12U & 63U];
        *to++ = kDigits[word >> 6U & 63U];
        *to++ = kDigits[word & 63U];
    }
    if (const std::size_t left = bytes.size() - i; left > 0) {
        const unsigned word = bytes[i] << 16U | (left == 2 ? bytes[i + 1] << 8U : 0U);
        *to++ = kDigits[word >> 18U];
        *to++ = kDigits[word >> 12U & 63U];
        if (left == 2) {
            *to++ = kDigits[word >> 6U & 63U];
        }
    }
}

bool read_base64(std::string_view text, std::vector<std::uint8_t>& bytes) {
    bytes.clear();
    bytes.reserve(text.size() / 4 * 3 + 3);
    for (int i = 0; i < 2 && text.ends_with('='); ++i) {
        text.remove_suffix(1);
    }
    unsigned word = 0;
    unsigned digits = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '\\' && i + 1 < text.size() && text[i + 1] == '/') {
            continue;
        }
        const unsigned value = kValues[static_cast<std::uint8_t>(text[i])];
        if (value == kNoDigit) {
            return false;
        }
        word = word << 6U | value;
        if (++digits == 4) {
            bytes.insert(bytes.end(), {static_cast<std::uint8_t>(word >> 16U), static_cast<std::uint8_t>(word >> 8U),
                                       static_cast<std::uint8_t>(word)});
            digits = 0;
        }
    }
    if (digits >= 2) {
        word <<= 6U * (4 - digits);
        bytes.push_back(static_cast<std::uint8_t>(word >> 16U));
        if (digits == 3) {
            bytes.push_back(static_cast<std::uint8_t>(word >> 8U));
        }
    }
    return digits != 1;
}

}  // namespace facet
