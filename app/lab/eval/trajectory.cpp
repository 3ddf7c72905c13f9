// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/trajectory.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <string_view>

#include "app/support/input_error.h"

namespace facet {
namespace {

constexpr double kNormTolerance = 0.01;
constexpr int kNanoDigits = 9;
constexpr std::size_t kTumColumns = 8;

/// Decimal seconds, also with an exponent, to nanoseconds without going through a double, which has only about 200 ns
/// at today's epoch. What is beyond the nanoseconds is cut off.
/// @param text  a number
/// @return false if it is out of the range of a stamp
bool parse_seconds(std::string_view text, Timestamp& stamp) {
    constexpr std::int64_t kMax_ns = 9'000'000'000'000'000'000;
    const bool negative = text.starts_with('-');
    text.remove_prefix(negative ? 1 : 0);
    const std::size_t e = text.find_first_of("eE");
    std::string_view exponent = e == std::string_view::npos ? std::string_view{} : text.substr(e + 1);
    exponent.remove_prefix(exponent.starts_with('+') ? 1 : 0);
    int shift = 0;
    if (std::from_chars(exponent.data(), exponent.data() + exponent.size(), shift).ec != std::errc() &&
        !exponent.empty()) {
        return false;
    }
    const std::string_view mantissa = text.substr(0, e);
    std::string digits;
    std::copy_if(mantissa.begin(), mantissa.end(), std::back_inserter(digits), [](char c) { return c != '.'; });
    // So many digits make up the nanoseconds; those that are not written are zero.
    const std::int64_t count =
        static_cast<std::int64_t>(std::min(mantissa.find('.'), mantissa.size())) + shift + kNanoDigits;
    std::int64_t ns = 0;
    for (std::int64_t i = 0; i < count; ++i) {
        const bool is_written = i < static_cast<std::int64_t>(digits.size());
        if ((!is_written && ns == 0) || ns > kMax_ns / 10) {
            break;
        }
        ns = 10 * ns + (is_written ? digits[static_cast<std::size_t>(i)] - '0' : 0);
        if (i + 1 == count) {
            stamp.ns = negative ? -ns : ns;
            return ns <= kMax_ns;
        }
    }
    stamp.ns = 0;
    return ns == 0;
}

std::vector<std::string_view> split(std::string_view row) {
    constexpr std::string_view kBlanks = " \t\r,";
    std::vector<std::string_view> fields;
    for (std::size_t begin = row.find_first_not_of(kBlanks); begin != std::string_view::npos;) {
        const std::size_t end = row.find_first_of(kBlanks, begin);
        fields.push_back(row.substr(begin, end - begin));
        begin = end == std::string_view::npos ? end : row.find_first_not_of(kBlanks, end);
    }
    return fields;
}

/// Empty if the row is good, else what is wrong.
std::string parse_row(const std::vector<std::string_view>& fields, StampedPose& pose) {
    if (fields.size() != kTumColumns) {
        return fmt::format("row has {} columns, not 8 (seconds x y z qx qy qz qw)", fields.size());
    }
    double seconds = 0.0;
    std::array<double, kTumColumns> x{};
    for (std::size_t i = 0; i < kTumColumns; ++i) {
        double& value = i == 0 ? seconds : x[i];
        const auto [end, error] = std::from_chars(fields[i].data(), fields[i].data() + fields[i].size(), value);
        if (error != std::errc() || end != fields[i].data() + fields[i].size() || !std::isfinite(value)) {
            return fmt::format("column {} is not a finite number", i + 1);
        }
    }
    if (!parse_seconds(fields[0], pose.stamp)) {
        return "stamp is out of range";
    }
    const Eigen::Quaterniond q(x[7], x[4], x[5], x[6]);
    if (std::abs(q.norm() - 1.0) > kNormTolerance) {
        return "quaternion is not of unit length";
    }
    pose.T_W_B = {q.normalized(), {x[1], x[2], x[3]}};
    return {};
}

Se3 interpolate(const StampedPose& a, const StampedPose& b, Timestamp t) {
    const double s = static_cast<double>((t - a.stamp).ns) / static_cast<double>((b.stamp - a.stamp).ns);
    return {a.T_W_B.q.slerp(s, b.T_W_B.q), (1.0 - s) * a.T_W_B.p + s * b.T_W_B.p};
}

}  // namespace

Trajectory read_tum(const std::string& path) {
    std::ifstream stream(path, std::ios::binary);
    if (!stream || stream.peek() == std::ifstream::traits_type::eof()) {
        if (stream.bad() || !stream.is_open()) {
            throw InputError(path + ": cannot be read");
        }
        return {};
    }
    Trajectory trajectory;
    std::string row;
    for (std::int64_t line = 1; std::getline(stream, row); ++line) {
        const std::vector<std::string_view> fields = split(row);
        if (fields.empty() || fields.front().starts_with('#')) {
            continue;
        }
        StampedPose pose;
        std::string problem = parse_row(fields, pose);
        if (problem.empty() && !trajectory.empty() && pose.stamp <= trajectory.back().stamp) {
            problem = "stamp does not increase";
        }
        if (!problem.empty() && stream.eof()) {
            break;  // a last line without an end: its writer was stopped
        }
        if (!problem.empty()) {
            throw InputError(fmt::format("{}:{}: {}", path, line, problem));
        }
        trajectory.push_back(pose);
    }
    return trajectory;
}

std::vector<PosePair> associate(const Trajectory& truth, const Trajectory& estimate, Duration max_gap) {
    std::vector<PosePair> pairs;
    for (const StampedPose& pose : estimate) {
        const auto after = std::lower_bound(truth.begin(), truth.end(), pose.stamp,
                                            [](const StampedPose& p, Timestamp t) { return p.stamp < t; });
        if (after == truth.end()) {
            continue;
        }
        if (after->stamp == pose.stamp) {
            pairs.push_back({pose.stamp, after->T_W_B, pose.T_W_B});
        } else if (after != truth.begin() && after->stamp - std::prev(after)->stamp <= max_gap) {
            pairs.push_back({pose.stamp, interpolate(*std::prev(after), *after, pose.stamp), pose.T_W_B});
        }
    }
    return pairs;
}

}  // namespace facet
