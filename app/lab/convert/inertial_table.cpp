// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/convert/inertial_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "app/lab/convert/plain_table.h"
#include "app/lab/convert/split_imu.h"
#include "app/support/input_error.h"
#include "drivers/replay_asl/csv_file.h"

namespace facet {
namespace {

constexpr double kLeastImuStep_s = 1e-4;
constexpr double kStandardGravity = 9.80665;
constexpr std::size_t kNowhere = static_cast<std::size_t>(-1);

bool contains_any(const std::string& text, std::initializer_list<const char*> parts) {
    return std::ranges::any_of(parts, [&](const char* part) { return text.find(part) != std::string::npos; });
}

/// A column's name without its unit: letters and digits alone; and the unit.
struct ColumnName {
    std::string word;
    std::string unit;
};
ColumnName parse_name(const std::string& name) {
    ColumnName parsed;
    const std::size_t bracket = name.find_first_of("[(");
    if (bracket != std::string::npos) {
        parsed.unit = name.substr(bracket + 1, name.find_first_of("])", bracket) - bracket - 1);
    }
    for (const char c : name.substr(0, bracket)) {
        if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9')) {
            parsed.word += c;
        }
    }
    return parsed;
}

/// x, y, z as 0, 1, 2 at one end of a name that is longer; none otherwise.
std::optional<std::size_t> axis_of(const std::string& word) {
    for (const char c : {word.back(), word.front()}) {
        if (c >= 'x' && c <= 'z') {
            return static_cast<std::size_t>(c - 'x');
        }
    }
    return word.back() >= '0' && word.back() <= '2' ? std::optional(static_cast<std::size_t>(word.back() - '0'))
                                                    : std::nullopt;
}

bool is_rate_name(const std::string& word) {
    return contains_any(word, {"gyr", "angvel", "angularvel", "omega", "rotationrate", "angrate", "angularrate"}) ||
           (word.front() == 'w' && word.size() <= 6) || word == "gx" || word == "gy" || word == "gz";
}
bool is_force_name(const std::string& word) {
    return contains_any(word, {"acc", "force"}) || (word.front() == 'a' && word.size() <= 6);
}

/// Where a table has what.
struct ImuColumns {
    std::size_t stamp = 0;
    std::size_t nanoseconds = kNowhere;  ///< of a stamp that has two columns
    std::array<std::size_t, 6> values{};
    std::array<double, 6> scales{1.0, 1.0, 1.0, 1.0, 1.0, 1.0};
    bool has_rates = true;
    bool has_forces = true;
    bool has_names = true;
};

double scale_of(const ColumnName& name, bool is_rate) {
    if (is_rate) {
        const bool is_degrees = contains_any(name.unit, {"deg", "dps", "\xC2\xB0"}) || name.word.ends_with("dps");
        return is_degrees ? std::numbers::pi / 180.0 : 1.0;
    }
    const bool is_gravity = name.unit == "g" || name.unit == "gs" || name.unit == "gravity";
    return is_gravity ? kStandardGravity : name.unit == "mg" ? 1e-3 * kStandardGravity : 1.0;
}

/// @param only  'w': the table is one of rates alone, 'a': of forces alone, 0: of both
ImuColumns columns_by_position(const PlainTable& table, std::size_t width, char only) {
    const std::size_t needed = only == 0 ? 7 : 4;
    // A counter of rows may stand before the stamp.
    if (width != needed && width != needed + 1) {
        table.fail(fmt::format("has {} columns: needed are stamp, {}, or names that say which column is what", width,
                               only == 0     ? "angular rate x y z, specific force x y z"
                               : only == 'w' ? "angular rate x y z"
                                             : "specific force x y z"));
    }
    ImuColumns columns;
    columns.has_names = false;
    columns.stamp = width - needed;
    columns.values.fill(kNowhere);
    columns.has_rates = only != 'a';
    columns.has_forces = only != 'w';
    for (std::size_t i = 1; i < needed; ++i) {
        columns.values[(only == 'a' ? 3 : 0) + i - 1] = columns.stamp + i;
    }
    return columns;
}

std::size_t stamp_by_name(const std::vector<std::string>& names, std::size_t& nanoseconds) {
    std::size_t chosen = kNowhere;
    for (std::size_t i = 0; i < names.size(); ++i) {
        const std::string& name = names[i];
        if (name.ends_with("nsecs") || name.ends_with("nsec") || name.ends_with("nanosec")) {
            nanoseconds = i;
        } else if (is_stamp_name(name) && (chosen == kNowhere || contains_any(name, {"header.stamp"})) &&
                   !(chosen != kNowhere && contains_any(names[chosen], {"stamp.sec"}))) {
            chosen = i;
        }
    }
    const bool has_both = nanoseconds != kNowhere && chosen != kNowhere && contains_any(names[chosen], {"sec"});
    nanoseconds = has_both ? nanoseconds : kNowhere;
    return chosen;
}

ImuColumns columns_of(const PlainTable& table, std::size_t width, char only) {
    const std::vector<std::string>& names = table.names();
    ImuColumns columns;
    columns.values.fill(kNowhere);
    const std::size_t stamp = stamp_by_name(names, columns.nanoseconds);
    std::size_t found = 0;
    for (std::size_t i = 0; i < names.size(); ++i) {
        const ColumnName name = parse_name(names[i]);
        if (i == stamp || name.word.empty() || contains_any(name.word, {"cov", "bias", "orientation"})) {
            continue;
        }
        const std::optional<std::size_t> axis = axis_of(name.word);
        const bool is_bare = name.word.size() == 1 && only != 0;  // x, y, z of one sensor
        const bool is_rate = is_bare ? only == 'w' : is_rate_name(name.word);
        if (!axis.has_value() || !(is_bare || is_rate || is_force_name(name.word))) {
            continue;
        }
        const std::size_t value = *axis + (is_rate ? 0 : 3);
        if (columns.values[value] == kNowhere) {
            columns.values[value] = i;
            columns.scales[value] = scale_of(name, is_rate);
            ++found;
        }
    }
    if (found == 0) {
        return columns_by_position(table, width, only);
    }
    const auto has = [&](std::size_t first) {
        return std::all_of(columns.values.begin() + static_cast<std::ptrdiff_t>(first),
                           columns.values.begin() + static_cast<std::ptrdiff_t>(first + 3),
                           [](std::size_t column) { return column != kNowhere; });
    };
    columns.has_rates = has(0) && only != 'a';
    columns.has_forces = has(3) && only != 'w';
    columns.stamp = stamp == kNowhere ? 0 : stamp;
    if (!(columns.has_rates || only == 'a') || !(columns.has_forces || only == 'w')) {
        throw InputError(fmt::format("{}: has no {} among its columns {}{}", table.path(),
                                     columns.has_rates ? "specific force x y z" : "angular rate x y z",
                                     fmt::join(names, ", "),
                                     only == 0 ? "; two tables are given as --imu GYROSCOPE,ACCELEROMETER" : ""));
    }
    return columns;
}

struct WrittenSample {
    WrittenStamp stamp;
    std::array<double, 6> values{};
};

/// Both sensors' values of a row; those of a sensor that the table lacks are zero.
std::optional<WrittenSample> parse_row(const std::vector<std::string_view>& fields, const ImuColumns& columns) {
    if (columns.stamp >= fields.size()) {
        return std::nullopt;
    }
    const std::optional<WrittenStamp> stamp = WrittenStamp::parse(fields[columns.stamp]);
    if (!stamp.has_value()) {
        return std::nullopt;
    }
    WrittenSample sample{*stamp, {}};
    if (columns.nanoseconds < fields.size()) {
        const std::optional<WrittenStamp> rest = WrittenStamp::parse(fields[columns.nanoseconds]);
        if (!rest.has_value()) {
            return std::nullopt;
        }
        sample.stamp.billionths = rest->whole;
    }
    for (std::size_t i = 0; i < 6; ++i) {
        if (!(i < 3 ? columns.has_rates : columns.has_forces)) {
            continue;
        }
        double value = 0.0;
        if (columns.values[i] >= fields.size() || !parse_double(fields[columns.values[i]], value) ||
            !std::isfinite(value)) {
            return std::nullopt;
        }
        sample.values[i] = columns.scales[i] * value;
    }
    return sample;
}

double median_norm(const std::vector<InertialSample>& samples, std::size_t first) {
    std::vector<double> norms;
    norms.reserve(samples.size());
    for (const InertialSample& sample : samples) {
        norms.push_back(std::hypot(sample.values[first], sample.values[first + 1], sample.values[first + 2]));
    }
    const auto middle = norms.begin() + static_cast<std::ptrdiff_t>(norms.size() / 2);
    std::ranges::nth_element(norms, middle);
    return *middle;
}

/// Gravity tells which of two sensors is which, and whether it was measured in multiples of itself.
void check_gravity(const std::string& path, bool has_names, std::vector<InertialSample>& samples,
                   const std::function<void(const std::string&)>& warn) {
    const auto is_gravity = [](double a) { return a > 8.0 && a < 12.0; };
    const double force = median_norm(samples, 3);
    if (!has_names && !is_gravity(force) && is_gravity(median_norm(samples, 0))) {
        for (InertialSample& sample : samples) {
            std::swap_ranges(sample.values.begin(), sample.values.begin() + 3, sample.values.begin() + 3);
        }
        warn(path + ": columns 2 to 4 hold gravity: they are taken as the specific force, 5 to 7 as the angular rate");
    } else if (force < 2.0) {
        warn(
            fmt::format("{}: the specific force is {:.3g} m/s^2 in the median: are these multiples of g, or is gravity "
                        "taken out? Neither will do",
                        path, force));
    }
}

/// @param only  as columns_of has it
InertialTable read_one(const std::string& path, char only, const std::function<void(const std::string&)>& warn) {
    PlainTable table(path);
    std::vector<std::string_view> fields;
    std::vector<WrittenSample> written;
    std::optional<ImuColumns> columns;
    InertialTable read;
    while (table.next(fields)) {
        columns = columns.has_value() ? columns : columns_of(table, fields.size(), only);
        if (const std::optional<WrittenSample> sample = parse_row(fields, *columns)) {
            written.push_back(*sample);
        } else {
            ++read.left_out;
        }
    }
    if (written.size() < 2) {
        throw InputError(path + ": holds no inertial samples");
    }
    const bool has_two_parts = columns->nanoseconds != kNowhere;
    const std::string name = columns->stamp < table.names().size() ? table.names()[columns->stamp] : "";
    std::vector<WrittenStamp> stamps;
    std::ranges::transform(written, std::back_inserter(stamps), &WrittenSample::stamp);
    const std::int64_t unit_ns = has_two_parts ? 1'000'000'000 : unit_of_stamps(stamps, name, kLeastImuStep_s, path);
    for (const WrittenSample& sample : written) {
        read.samples.push_back({sample.stamp.ns(unit_ns), sample.values});
    }
    std::ranges::stable_sort(read.samples, {}, &InertialSample::stamp_ns);
    const auto is_repeated = [](const InertialSample& a, const InertialSample& b) { return a.stamp_ns == b.stamp_ns; };
    const auto end = std::unique(read.samples.begin(), read.samples.end(), is_repeated);
    read.left_out += static_cast<std::uint64_t>(read.samples.end() - end);
    read.samples.erase(end, read.samples.end());
    if (only == 0) {
        check_gravity(path, columns->has_names, read.samples, warn);
    }
    return read;
}

}  // namespace

InertialTable read_inertial_table(const std::string& paths, const std::function<void(const std::string&)>& warn) {
    const std::size_t comma = paths.find(',');
    if (comma == std::string::npos) {
        return read_one(paths, 0, warn);
    }
    const InertialTable rates = read_one(paths.substr(0, comma), 'w', warn);
    const InertialTable forces = read_one(paths.substr(comma + 1), 'a', warn);
    SplitImu split;
    for (const InertialSample& sample : rates.samples) {
        split.add_rates({sample.stamp_ns, {sample.values[0], sample.values[1], sample.values[2]}});
    }
    for (const InertialSample& sample : forces.samples) {
        split.add_forces({sample.stamp_ns, {sample.values[3], sample.values[4], sample.values[5]}});
    }
    InertialTable both;
    both.left_out = rates.left_out + split.finish([&](std::int64_t stamp_ns, const std::array<double, 6>& values) {
        both.samples.push_back({stamp_ns, values});
    });
    if (both.samples.empty()) {
        throw InputError(paths + ": the two have no time in common");
    }
    check_gravity(paths, true, both.samples, warn);
    return both;
}

}  // namespace facet
