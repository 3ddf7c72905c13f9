// SPDX-License-Identifier: BSD-2-Clause
// The members of a JSON object as they stand in the text.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace facet {

/// The text of a member's value, or nothing if the text is no object or has no such member. It is not unescaped and not
/// copied: numbers keep their digits, and an image of half a megabyte is passed over at once. What stands inside values
/// is looked at only as far as needed to find their ends. Names with escapes are not found. Reentrant. No heap.
std::optional<std::string_view> json_member(std::string_view object, std::string_view name);

/// Likewise through objects inside each other.
template <class... Names>
std::optional<std::string_view> json_member(std::string_view object, std::string_view name, Names... inner) {
    const std::optional<std::string_view> value = json_member(object, name);
    return value.has_value() ? json_member(*value, inner...) : std::nullopt;
}

/// Whether a text is a number as JSON has them: no plus sign, no leading zero, no bare point, no nan.
bool is_json_number(std::string_view text);

/// A string's content, if it has no escapes.
std::optional<std::string_view> json_plain_text(std::string_view value);

/// Appends bytes in base64 with padding (RFC 4648).
void append_base64(std::span<const std::uint8_t> bytes, std::string& out);

/// Replaces `bytes` by what a text in base64 says, with padding or without; \/ counts as /.
/// @return false if it is not base64
bool read_base64(std::string_view text, std::vector<std::uint8_t>& bytes);

}  // namespace facet
