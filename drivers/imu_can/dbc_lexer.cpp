// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/imu_can/dbc_lexer.h"

#include <charconv>
#include <cmath>

namespace facet {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_word(char c) { return is_digit(c) || c == '_' || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\f' || c == '\v'; }

}  // namespace

bool parse_number(std::string_view digits, std::uint64_t& value) {
    std::uint64_t parsed = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), parsed);
    if (error != std::errc() || end != digits.data() + digits.size()) {
        return false;
    }
    value = parsed;
    return true;
}

DbcLexer::DbcLexer(std::string_view text) : text_(text) {
    if (text_.starts_with("\xEF\xBB\xBF")) {
        position_ = 3;
    }
}

void DbcLexer::move_to(std::size_t position) {
    for (; position_ < position; ++position_) {
        next_line_ += text_[position_] == '\n' ? 1 : 0;
    }
}

void DbcLexer::skip_blanks() {
    while (position_ < text_.size() && is_blank(text_[position_])) {
        move_to(position_ + 1);
    }
    line_ = next_line_;
}

bool DbcLexer::at_end() {
    skip_blanks();
    return position_ == text_.size();
}

bool DbcLexer::word(std::string& value) {
    skip_blanks();
    std::size_t end = position_;
    while (end < text_.size() && is_word(text_[end])) {
        ++end;
    }
    if (end == position_) {
        return false;
    }
    value = text_.substr(position_, end - position_);
    move_to(end);
    return true;
}

bool DbcLexer::number(std::uint64_t& value) {
    skip_blanks();
    std::size_t end = position_;
    while (end < text_.size() && is_word(text_[end])) {
        ++end;
    }
    if (!parse_number(text_.substr(position_, end - position_), value)) {
        return false;
    }
    move_to(end);
    return true;
}

bool DbcLexer::digit(std::uint64_t& value) {
    skip_blanks();
    if (position_ == text_.size() || !is_digit(text_[position_])) {
        return false;
    }
    value = static_cast<std::uint64_t>(text_[position_] - '0');
    move_to(position_ + 1);
    return true;
}

bool DbcLexer::real(double& value) {
    skip_blanks();
    std::string_view rest = text_.substr(position_);
    const std::size_t plus = rest.starts_with('+') ? 1 : 0;
    rest.remove_prefix(plus);
    double parsed = 0.0;
    const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), parsed);
    if (error != std::errc() || !std::isfinite(parsed)) {
        return false;
    }
    value = parsed;
    move_to(position_ + plus + static_cast<std::size_t>(end - rest.data()));
    return true;
}

bool DbcLexer::read_text(std::size_t& at, std::string* value) const {
    std::size_t i = at + 1;
    for (; i < text_.size() && text_[i] != '"'; ++i) {
        if (text_[i] == '\\' && i + 1 < text_.size() && text_[i + 1] == '"') {
            ++i;
        }
        if (value != nullptr) {
            *value += text_[i];
        }
    }
    if (i >= text_.size()) {
        return false;
    }
    at = i + 1;
    return true;
}

bool DbcLexer::text(std::string& value) {
    skip_blanks();
    std::string read;
    std::size_t end = position_;
    if (position_ == text_.size() || text_[position_] != '"' || !read_text(end, &read)) {
        return false;
    }
    value = std::move(read);
    move_to(end);
    return true;
}

bool DbcLexer::symbol(char c) {
    skip_blanks();
    if (position_ == text_.size() || text_[position_] != c) {
        return false;
    }
    move_to(position_ + 1);
    return true;
}

void DbcLexer::skip_line() {
    const std::size_t end = text_.find('\n', position_);
    move_to(end == std::string_view::npos ? text_.size() : end);
}

void DbcLexer::skip_indented_lines() {
    // At the end of a line: look at what the next one starts with; an empty line goes on.
    while (position_ < text_.size()) {
        const std::size_t start = position_ + 1;
        if (start < text_.size() && !is_blank(text_[start])) {
            return;
        }
        move_to(start);
        skip_line();
    }
}

bool DbcLexer::skip_past_semicolon() {
    for (std::size_t i = position_; i < text_.size();) {
        if (text_[i] == '"') {
            if (!read_text(i, nullptr)) {
                return false;
            }
        } else if (text_[i++] == ';') {
            move_to(i);
            return true;
        }
    }
    return false;
}

}  // namespace facet
