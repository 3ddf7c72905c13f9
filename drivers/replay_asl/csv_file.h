// SPDX-License-Identifier: BSD-2-Clause
// Reads a CSV file of numbers row by row, with line numbers.
#pragma once

#include <cstdint>
#include <istream>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace facet {

/// A CSV file as found in logs: comma-separated, comment lines with '#', blank lines, LF or CRLF, the last newline
/// optional, a byte order mark tolerated. Blank and comment lines are skipped but counted. Thread-bound. Heap: a line
/// buffer.
class CsvFile {
public:
    /// @return false if the file cannot be opened for reading, or is no regular file.
    bool open(const std::string& path);
    /// Likewise with what the file holds, from elsewhere; false for nullptr. @param path  for messages
    bool open(const std::string& path, std::unique_ptr<std::istream> content);

    static constexpr std::size_t kMaxLine = 4096;  ///< bytes; what is longer counts as one field of that length

    /// Next row with content. Its fields (trimmed) stay valid until the next call.
    /// @return false at the end of the file or on a read error (see failed)
    bool next(std::vector<std::string_view>& fields);

    /// True if reading stopped because of an input/output error rather than the end.
    bool failed() const { return stream_ != nullptr && stream_->bad(); }
    std::int64_t line() const { return line_; }  ///< of the row returned last, from 1
    const std::string& path() const { return path_; }

private:
    bool next_line(std::string_view& row, bool& is_too_long);

    std::unique_ptr<std::istream> stream_;
    std::string path_;
    std::vector<char> buffer_;
    std::int64_t line_ = 0;
};

/// Conversions of whole fields, independent of the locale; false if the field is anything but such a number.
bool parse_int64(std::string_view field, std::int64_t& value);
/// A stamp in integer nanoseconds, within 146 years of the epoch: twice that far apart, differences still fit.
bool parse_stamp(std::string_view field, std::int64_t& ns);
/// Accepts what strtod does in the C locale except hexadecimal; "nan" and "inf" count as numbers.
bool parse_double(std::string_view field, double& value);

}  // namespace facet
