// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/convert/plain_table.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include "app/support/input_error.h"
#include "drivers/replay_asl/csv_file.h"
#include "platform/base/regular_file.h"

namespace facet {
namespace {

constexpr std::string_view kTableBlanks = " \t\r\v\f";
constexpr std::int64_t kBillion = 1'000'000'000;

std::string_view without_blanks(std::string_view text) {
    const std::size_t begin = text.find_first_not_of(kTableBlanks);
    return begin == std::string_view::npos ? std::string_view{}
                                           : text.substr(begin, text.find_last_not_of(kTableBlanks) - begin + 1);
}

bool is_number(std::string_view field) {
    double number = 0.0;
    return parse_double(field, number);
}

bool is_image_name(std::string_view field) {
    constexpr std::array<std::string_view, 8> kEndings{".png", ".jpg", ".jpeg", ".pgm",
                                                       ".ppm", ".tif", ".tiff", ".bmp"};
    return std::ranges::any_of(kEndings, [&](std::string_view ending) { return field.ends_with(ending); });
}

bool is_comment(std::string_view row) { return row.front() == '#' || row.front() == '%'; }

char separator_of(std::string_view row) {
    for (const char candidate : {',', ';', '\t'}) {
        if (row.find(candidate) != std::string_view::npos) {
            return candidate;
        }
    }
    return ' ';
}

}  // namespace

PlainTable::PlainTable(const std::string& path) : path_(path) {
    if (const std::string refusal = refuse_file(path); !refusal.empty()) {
        throw InputError(path + ": " + refusal);
    }
    stream_.open(path, std::ios::binary);
    std::string header;
    while (next_line()) {
        if (is_comment(row_)) {
            header = row_.substr(1);
            continue;
        }
        separator_ = separator_of(row_);
        const std::vector<std::string_view> first = split(row_);
        is_first_read_ =
            std::ranges::any_of(first, [](auto field) { return is_number(field) || is_image_name(field); });
        const std::vector<std::string_view> names = is_first_read_ ? split(header) : first;
        if (!is_first_read_ || names.size() == first.size()) {
            names_.assign(names.begin(), names.end());
        }
        break;
    }
    for (std::string& name : names_) {
        std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
    }
}

bool PlainTable::next_line() {
    while (std::getline(stream_, row_)) {
        if (++line_ == 1 && row_.starts_with("\xEF\xBB\xBF")) {
            row_.erase(0, 3);
        }
        row_ = std::string(without_blanks(row_));
        if (!row_.empty()) {
            return true;
        }
    }
    return false;
}

std::vector<std::string_view> PlainTable::split(std::string_view row) const {
    std::vector<std::string_view> fields;
    row = without_blanks(row);
    while (!row.empty()) {
        const std::size_t end = separator_ == ' ' ? row.find_first_of(kTableBlanks) : row.find(separator_);
        std::string_view field = without_blanks(row.substr(0, end));
        if (field.size() > 1 && field.front() == '"' && field.back() == '"') {
            field = field.substr(1, field.size() - 2);
        }
        fields.push_back(field);
        row = end == std::string_view::npos ? std::string_view{} : row.substr(end + 1);
        if (separator_ == ' ') {
            row = without_blanks(row);
        }
    }
    return fields;
}

bool PlainTable::next(std::vector<std::string_view>& fields) {
    do {
        if (!is_first_read_ && !next_line()) {
            return false;
        }
        is_first_read_ = false;
    } while (is_comment(row_));
    fields = split(row_);
    return true;
}

void PlainTable::fail(const std::string& message) const {
    throw InputError(fmt::format("{}:{}: {}", path_, line_, message));
}

std::optional<WrittenStamp> WrittenStamp::parse(std::string_view text) {
    const std::size_t point = text.find('.');
    const std::string_view fraction = point == std::string_view::npos ? std::string_view{} : text.substr(point + 1);
    WrittenStamp stamp;
    const bool is_plain = parse_stamp(text.substr(0, point), stamp.whole) && !text.starts_with('-') &&
                          std::ranges::all_of(fraction, [](char c) { return c >= '0' && c <= '9'; });
    if (is_plain) {
        for (std::size_t i = 0; i < 9; ++i) {
            stamp.billionths = 10 * stamp.billionths + (i < fraction.size() ? fraction[i] - '0' : 0);
        }
        return stamp;
    }
    constexpr double kMost = 4e18;
    double number = 0.0;  // with an exponent, or negative
    if (!parse_double(text, number) || !(std::abs(number) < kMost)) {
        return std::nullopt;
    }
    const double whole = std::floor(number);
    return WrittenStamp{static_cast<std::int64_t>(whole),
                        static_cast<std::int64_t>((number - whole) * static_cast<double>(kBillion))};
}

std::int64_t WrittenStamp::ns(std::int64_t unit_ns) const {
    constexpr std::int64_t kMost_ns = std::int64_t{1} << 62U;
    if (std::abs(whole) > kMost_ns / unit_ns - 1) {
        return whole < 0 ? -kMost_ns : kMost_ns;
    }
    return whole * unit_ns + (billionths * (unit_ns / 1000) + 500'000) / 1'000'000;
}

bool is_stamp_name(std::string_view name) {
    const auto has = [&](std::string_view part) { return name.find(part) != std::string_view::npos; };
    return has("time") || has("stamp") || name == "t" || name == "ts" || name.starts_with("t ") ||
           name.starts_with("t[") || name.starts_with("t_") || name.starts_with("ts_");
}

std::int64_t unit_of_stamps(std::span<const WrittenStamp> stamps, const std::string& name, double least_s,
                            const std::string& path) {
    constexpr std::array<std::pair<const char*, std::int64_t>, 4> kUnits{
        {{"ns", 1}, {"us", 1000}, {"ms", 1'000'000}, {"s", kBillion}}};
    std::string words = name + ' ';
    std::ranges::replace_if(
        words, [](char c) { return c == '_' || c == '[' || c == ']' || c == '(' || c == ')' || c == '.'; }, ' ');
    for (const auto& [unit, ns] : kUnits) {
        if (words.find(fmt::format(" {} ", unit)) != std::string::npos) {
            return ns;
        }
    }
    std::vector<double> steps;
    for (std::size_t i = 1; i < stamps.size(); ++i) {
        const double whole = static_cast<double>(stamps[i].whole - stamps[i - 1].whole);
        steps.push_back(whole + static_cast<double>(stamps[i].billionths - stamps[i - 1].billionths) * 1e-9);
    }
    if (steps.empty()) {
        throw InputError(path + ": has fewer than two rows with a stamp");
    }
    std::ranges::nth_element(steps, steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2));
    const double step = steps[steps.size() / 2];
    for (const auto& [unit, ns] : kUnits) {
        const double step_s = step * static_cast<double>(ns) * 1e-9;
        if (step_s >= least_s && step_s < 1000.0 * least_s) {
            return ns;
        }
    }
    throw InputError(fmt::format("{}: stamps whose median step is {:.6g} fit neither ns, us, ms nor s of such a sensor",
                                 path, step));
}

}  // namespace facet
