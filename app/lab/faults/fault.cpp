// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/faults/fault.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/support/input_error.h"
#include "drivers/replay_asl/csv_file.h"

namespace facet {
namespace {

constexpr double kMaxTime = 1e6;                     // s; keeps nanoseconds far from overflow
constexpr Duration kForever{std::int64_t{1} << 61};  // ns, 73 years

/// A specification being read, for messages that quote it.
class Reader {
public:
    explicit Reader(std::string_view spec) : spec_(spec) {}

    [[noreturn]] void fail(const std::string& complaint) const {
        throw InputError(fmt::format("--inject '{}': {}", spec_, complaint));
    }

    double number(const char* what, std::string_view token, double min, double max) const {
        double value = 0.0;
        if (!parse_double(token, value)) {
            fail(fmt::format("{} '{}' is not a number", what, token));
        }
        if (!(value >= min && value <= max)) {
            fail(fmt::format("{} '{}' must be within [{}, {}]", what, token, min, max));
        }
        return value;
    }

    double word(const FaultValue& value, std::string_view token) const {
        const auto found = std::find(value.words.begin(), value.words.end(), token);
        if (found == value.words.end()) {
            fail(fmt::format("{} '{}' must be one of {}", value.name, token, fmt::join(value.words, ", ")));
        }
        return static_cast<double>(found - value.words.begin());
    }

private:
    std::string_view spec_;
};

/// Splits at the first `mark`: what is before stays in `text`. @return whether there was one
bool split(std::string_view& text, char mark, std::string_view& rest) {
    const std::size_t at = text.find(mark);
    if (at == std::string_view::npos) {
        return false;
    }
    rest = text.substr(at + 1);
    text = text.substr(0, at);
    return true;
}

const FaultInfo& find_info(std::string_view name, const Reader& reader) {
    const std::vector<FaultInfo>& table = fault_table();
    const auto found = std::find_if(table.begin(), table.end(), [&](const FaultInfo& f) { return f.name == name; });
    if (found == table.end()) {
        std::string names;
        for (const FaultInfo& info : table) {
            names += (names.empty() ? "" : ", ") + std::string(info.name);
        }
        reader.fail(fmt::format("unknown fault '{}'; must be one of {}", name, names));
    }
    return *found;
}

void read_values(const FaultInfo& info, std::string_view text, bool is_given, const Reader& reader, Fault& fault) {
    for (std::size_t i = 0; i < info.values.size(); ++i) {
        const FaultValue& value = info.values[i];
        std::string_view rest;
        const std::string_view token = text;
        if (is_given) {
            std::string_view head = token;
            const bool more = split(head, ',', rest);
            fault.values.at(i) =
                value.words.empty() ? reader.number(value.name, head, value.min, value.max) : reader.word(value, head);
            is_given = more;
            text = rest;
        } else if (std::isnan(value.fallback)) {
            reader.fail(fmt::format("'{}' needs a value: {}={}", info.name, info.name, value.name));
        } else {
            fault.values.at(i) = value.fallback;
        }
    }
    if (is_given) {
        reader.fail(info.values.empty() ? fmt::format("'{}' takes no value, found '{}'", info.name, text)
                                        : fmt::format("'{}' takes no further value '{}'", info.name, text));
    }
}

}  // namespace

Fault parse_fault(std::string_view spec) {
    const Reader reader(spec);
    Fault fault;
    fault.spec = std::string(spec);
    fault.length = kForever;
    std::string_view head = spec;
    std::string_view window;
    std::string_view values;
    const bool has_window = split(head, '@', window);
    const bool has_values = split(head, '=', values);
    const FaultInfo& info = find_info(head, reader);
    fault.kind = info.kind;
    read_values(info, values, has_values, reader, fault);
    if (has_window && info.is_constant) {
        reader.fail(fmt::format("'{}' holds for the whole run: no start", info.name));
    }
    if (has_window) {
        std::string_view length;
        const bool has_length = split(window, '+', length);
        fault.begin = Duration::from_seconds(reader.number("start", window, 0.0, kMaxTime));
        if (has_length) {
            fault.length = Duration::from_seconds(reader.number("length", length, 1e-6, kMaxTime));
        }
    }
    return fault;
}

std::string fault_help() {
    std::string text =
        "Faults for --inject, NAME[=VALUE][@START[+LENGTH]]: START in seconds after the first replayed frame (0 by "
        "default), LENGTH in seconds (to the end by default). Faults may be combined, and are the same each time:\n";
    for (const FaultInfo& info : fault_table()) {
        std::string usage = info.name;
        std::string defaults;
        std::string close;
        for (std::size_t i = 0; i < info.values.size(); ++i) {
            const FaultValue& value = info.values[i];
            const bool is_optional = !std::isnan(value.fallback);
            usage += fmt::format("{}{}{}", is_optional ? "[" : "", i == 0 ? "=" : ",", value.name);
            close += is_optional ? "]" : "";
            if (is_optional) {
                defaults += fmt::format("{}{} {}", defaults.empty() ? " (default " : ", ", value.name,
                                        value.words.empty() ? fmt::format("{}", value.fallback)
                                                            : value.words.at(static_cast<std::size_t>(value.fallback)));
            }
        }
        defaults += defaults.empty() ? "" : ")";
        usage += close;
        text += fmt::format("  {:<27}{}{}{}\n", usage, usage.size() > 27 ? "\n" + std::string(30, ' ') : " ",
                            info.meaning, defaults);
    }
    return text;
}

}  // namespace facet
