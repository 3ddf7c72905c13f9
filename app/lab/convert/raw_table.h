// SPDX-License-Identifier: BSD-2-Clause
// Reads a log's table and says whether its rows alone make it again, byte for byte.
#pragma once

#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

namespace facet {

/// A data.csv: lines that begin with # first (its header), then rows. Like CsvFile it skips blank and comment lines and
/// trims fields, but it remembers whether that lost anything. Thread-bound. Heap: a line.
class RawTable {
public:
    /// @return false if it cannot be read or is no regular file
    bool open(const std::string& path);

    /// The header with its line ends; of the first kMostHeader bytes.
    const std::string& header() const { return header_; }
    /// "\n" or "\r\n": that of the first line.
    const std::string& line_end() const { return line_end_; }

    /// Next row with this number of fields, or with that one, and a stamp that is not negative; others are passed over.
    /// @return false at the end
    bool next(std::size_t fields, std::size_t or_fields);
    std::int64_t stamp_ns() const { return stamp_ns_; }
    /// What is behind the stamp; valid until the next row is read.
    const std::vector<std::string_view>& fields() const { return fields_; }

    /// Whether header, line end and the rows given so far are all that is in the file up to here.
    bool is_regular() const { return is_regular_; }
    /// For what only the caller can see of a row.
    void set_irregular() { is_regular_ = false; }

private:
    static constexpr std::size_t kMostLine = 4096;  ///< as in CsvFile
    static constexpr std::size_t kMostHeader = 4096;

    bool next_line();
    bool split_row(std::size_t fields, std::size_t or_fields);

    std::ifstream stream_;
    std::string header_;
    std::string line_end_;
    std::string line_;  ///< with its end
    bool has_line_ = false;
    bool is_given_ = false;  ///< the line is the row that was given last
    std::int64_t stamp_ns_ = 0;
    std::vector<std::string_view> fields_;
    bool is_regular_ = true;
};

}  // namespace facet
