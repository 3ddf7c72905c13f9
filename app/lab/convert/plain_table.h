// SPDX-License-Identifier: BSD-2-Clause
// Tables of text as people bring them: separators, headers and stamps in whatever form.
#pragma once

#include <cstdint>
#include <fstream>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace facet {

/// Rows of fields between commas, semicolons, tabs or blanks, by what the first row has; quotation marks around a field
/// are dropped. Lines that begin with '#' or '%' are comments; the last one before the rows, if it has as many fields,
/// or a first row without a number or
/// an image, names the columns. LF or CRLF, a byte order mark tolerated. Thread-bound. Heap.
class PlainTable {
public:
    /// Throws InputError if the file cannot be read.
    explicit PlainTable(const std::string& path);

    /// Of the columns, in lower case; empty without a header.
    const std::vector<std::string>& names() const { return names_; }

    /// @return false at the end. The fields stay valid until the next call.
    bool next(std::vector<std::string_view>& fields);

    std::int64_t line() const { return line_; }  ///< of the row returned last, from 1
    const std::string& path() const { return path_; }

    /// Throws InputError "file:line: message".
    [[noreturn]] void fail(const std::string& message) const;

private:
    bool next_line();
    std::vector<std::string_view> split(std::string_view row) const;

    std::string path_;
    std::ifstream stream_;
    std::string row_;
    char separator_ = ' ';
    bool is_first_read_ = false;  ///< row_ is still to be given
    std::int64_t line_ = 0;
    std::vector<std::string> names_;
};

/// A stamp as it is written, before its unit is known: no digit is lost.
struct WrittenStamp {
    std::int64_t whole = 0;
    std::int64_t billionths = 0;

    static std::optional<WrittenStamp> parse(std::string_view text);
    /// Within 146 years of zero. @param unit_ns  1, 1e3, 1e6 or 1e9
    std::int64_t ns(std::int64_t unit_ns) const;
};

/// Nanoseconds in the unit of a column: what its name says ("[us]", "stamp_ms"), else the unit, of ns, us, ms and s, by
/// which the median step between rows is within [least_s, 1000 least_s).
/// Throws InputError that begins with `path` if there is none.
std::int64_t unit_of_stamps(std::span<const WrittenStamp> stamps, const std::string& name, double least_s,
                            const std::string& path);

/// Whether the column's name means a stamp.
bool is_stamp_name(std::string_view name);

}  // namespace facet
