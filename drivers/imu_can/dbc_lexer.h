// SPDX-License-Identifier: BSD-2-Clause
// Words, numbers and texts of a DBC file, with line numbers.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace facet {

/// Parses decimal digits; false if there is any other character or the number is too large.
bool parse_number(std::string_view digits, std::uint64_t& value);

/// Reads from left to right and skips blanks and line ends. A function that returns false leaves its output untouched
/// and consumes nothing. Thread-bound. The text must outlive the lexer.
class DbcLexer {
public:
    explicit DbcLexer(std::string_view text);

    bool at_end();
    /// An identifier: letters, digits, underscores.
    bool word(std::string& value);
    /// An unsigned integer that no word character follows.
    bool number(std::uint64_t& value);
    /// One decimal digit, whatever follows.
    bool digit(std::uint64_t& value);
    /// A number with sign, fraction and exponent.
    bool real(double& value);
    /// Between double quotes, with \" inside; may span lines.
    bool text(std::string& value);
    bool symbol(char c);

    void skip_line();
    void skip_indented_lines();
    bool skip_past_semicolon();

    /// Of the last thing read, from 1.
    int line() const { return line_; }

private:
    bool read_text(std::size_t& at, std::string* value) const;
    void skip_blanks();
    void move_to(std::size_t position);

    std::string_view text_;
    std::size_t position_ = 0;
    int line_ = 1;       ///< of the last thing read
    int next_line_ = 1;  ///< of position_
};

}  // namespace facet
