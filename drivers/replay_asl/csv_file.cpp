// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/replay_asl/csv_file.h"

#include <charconv>
#include <fstream>
#include <limits>
#include <utility>

#include "platform/base/regular_file.h"

namespace facet {
namespace {

constexpr std::string_view kBlanks = " \t\r\v\f";

std::string_view trim(std::string_view s) {
    const std::size_t first = s.find_first_not_of(kBlanks);
    if (first == std::string_view::npos) {
        return {};
    }
    return s.substr(first, s.find_last_not_of(kBlanks) - first + 1);
}

}  // namespace

bool CsvFile::open(const std::string& path) {
    // A folder can be opened, but reading from it fails; an empty file merely ends.
    return open(path, refuse_file(path).empty() ? std::make_unique<std::ifstream>(path, std::ios::binary) : nullptr);
}

bool CsvFile::open(const std::string& path, std::unique_ptr<std::istream> content) {
    path_ = path;
    line_ = 0;
    stream_ = std::move(content);
    if (stream_ == nullptr || !*stream_ || (stream_->peek(), stream_->bad())) {
        stream_.reset();
        return false;
    }
    stream_->clear();
    return true;
}

/// Reads a line. @return false at the end of the file
bool CsvFile::next_line(std::string_view& row, bool& is_too_long) {
    if (stream_ == nullptr) {
        return false;
    }
    buffer_.resize(kMaxLine + 1);
    stream_->getline(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
    const auto got = static_cast<std::size_t>(stream_->gcount());  // the line's end included, if it was reached
    is_too_long = stream_->fail() && !stream_->eof() && got == kMaxLine;
    row = {buffer_.data(), is_too_long || stream_->eof() || got == 0 ? got : got - 1};
    if (is_too_long) {
        stream_->clear();
        stream_->ignore(std::numeric_limits<std::streamsize>::max(), '\n');
    }
    return is_too_long || static_cast<bool>(*stream_);
}

bool CsvFile::next(std::vector<std::string_view>& fields) {
    bool is_too_long = false;
    for (std::string_view row; next_line(row, is_too_long);) {
        ++line_;
        if (is_too_long) {
            fields.assign(1, row);
            return true;
        }
        if (line_ == 1 && row.starts_with("\xEF\xBB\xBF")) {
            row.remove_prefix(3);
        }
        row = trim(row);
        if (row.empty() || row.front() == '#') {
            continue;
        }
        fields.clear();
        for (;;) {
            const std::size_t comma = row.find(',');
            fields.push_back(trim(row.substr(0, comma)));
            if (comma == std::string_view::npos) {
                return true;
            }
            row.remove_prefix(comma + 1);
        }
    }
    return false;
}

bool parse_int64(std::string_view field, std::int64_t& value) {
    if (field.starts_with('+')) {
        field.remove_prefix(1);
    }
    std::int64_t parsed = 0;
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), parsed);
    if (error != std::errc() || end != field.data() + field.size()) {
        return false;
    }
    value = parsed;
    return true;
}

bool parse_stamp(std::string_view field, std::int64_t& ns) {
    constexpr std::int64_t kLimit = std::int64_t{1} << 62U;
    std::int64_t parsed = 0;
    if (!parse_int64(field, parsed) || parsed <= -kLimit || parsed >= kLimit) {
        return false;
    }
    ns = parsed;
    return true;
}

bool parse_double(std::string_view field, double& value) {
    if (field.starts_with('+')) {
        field.remove_prefix(1);
    }
    double parsed = 0.0;
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), parsed);
    if (error != std::errc() || end != field.data() + field.size()) {
        return false;
    }
    value = parsed;
    return true;
}

}  // namespace facet
