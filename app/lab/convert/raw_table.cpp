// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/convert/raw_table.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "drivers/replay_asl/csv_file.h"
#include "platform/base/regular_file.h"

namespace facet {
namespace {

std::string_view trimmed(std::string_view text) {
    constexpr std::string_view kBlanks = " \t\r\v\f\n";
    const std::size_t first = text.find_first_not_of(kBlanks);
    return first == std::string_view::npos ? std::string_view()
                                           : text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

}  // namespace

bool RawTable::open(const std::string& path) {
    *this = RawTable();
    if (!refuse_file(path).empty()) {
        return false;
    }
    stream_.open(path, std::ios::binary);
    if (!stream_ || (stream_.peek(), stream_.bad())) {
        return false;
    }
    stream_.clear();
    has_line_ = next_line();
    line_end_ = has_line_ && line_.ends_with("\r\n") ? "\r\n" : "\n";
    while (has_line_ && line_.starts_with('#') && header_.size() + line_.size() <= kMostHeader) {
        header_ += line_;
        has_line_ = next_line();
    }
    return true;
}

/// Reads a line with its end; of one that is too long, its beginning.
bool RawTable::next_line() {
    line_.resize(kMostLine);
    stream_.getline(line_.data(), static_cast<std::streamsize>(line_.size()));
    const auto got = static_cast<std::size_t>(stream_.gcount());
    if (stream_.bad() || (got == 0 && stream_.eof())) {
        return false;
    }
    if (stream_.eof()) {  // no end: nothing makes such a line again
        line_.resize(got);
        is_regular_ = false;
        return true;
    }
    if (stream_.fail()) {
        stream_.clear();
        stream_.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
        line_.resize(got);
        is_regular_ = false;
        return true;
    }
    line_.resize(got);
    line_.back() = '\n';  // in place of the terminating zero
    return true;
}

/// @return whether the line is a row of interest
bool RawTable::split_row(std::size_t fields, std::size_t or_fields) {
    const std::string_view row = trimmed(line_);
    if (row.empty() || row.front() == '#') {
        return false;
    }
    fields_.clear();
    for (std::size_t begin = 0; begin <= row.size();) {
        const std::size_t comma = std::min(row.find(',', begin), row.size());
        fields_.push_back(trimmed(row.substr(begin, comma - begin)));
        begin = comma + 1;
    }
    if ((fields_.size() != fields && fields_.size() != or_fields) || !parse_stamp(fields_[0], stamp_ns_) ||
        stamp_ns_ < 0) {
        return false;
    }
    std::string again = std::to_string(stamp_ns_);
    fields_.erase(fields_.begin());
    for (const std::string_view field : fields_) {
        (again += ',') += field;
    }
    is_regular_ = is_regular_ && again + line_end_ == line_;
    return true;
}

bool RawTable::next(std::size_t fields, std::size_t or_fields) {
    for (; has_line_; has_line_ = next_line()) {
        if (!std::exchange(is_given_, true)) {  // else the line is that of the row before
            if (split_row(fields, or_fields)) {
                return true;
            }
            is_regular_ = false;
        }
        is_given_ = false;
    }
    return false;
}

}  // namespace facet
