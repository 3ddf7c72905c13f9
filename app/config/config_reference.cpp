// SPDX-License-Identifier: BSD-2-Clause
#include "app/config/config_reference.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "app/config/config_table.h"
#include "app/config/vehicle_file.h"
#include "app/config/vehicle_keys.h"
#include "app/support/yaml_section.h"

namespace facet {
namespace {

/// A vehicle, and what its keys need that others do not have.
struct Example {
    const char* kind;  ///< empty: nothing
    const char* text;
};

constexpr const char* kRestOfVehicle = R"(
calibration: {}
estimator: {}
cameras:
  auto_exposure: {exposure_step_s: 1e-5, most_exposure: 1}
  left: {device: /dev/video0}
  right: {device: /dev/video1}
trigger: {line: 0}
trigger_output: {pwm: {}}
sinks:
  T_body_imu: {}
  mavlink: {obstacles: {}, range_finder: {}, origin: {latitude_deg: 0, longitude_deg: 0}}
  can: {interface: can0}
  world: {path: /run/facet/world}
  ros2: {}
  log: {folder: log}
ros2: {}
realtime: {threads: {estimator: {}, cameras: {}, imu: {}, trigger: {}, output: {}}}
)";

constexpr std::array kExamples{
    Example{"", "imu: {spi: {chip: adis16448, data_ready: {line: 0}}}"},
    Example{"chip: icm42688", "imu: {spi: {chip: icm42688}}"},
    Example{"chip: bmi088", "imu: {spi: {chip: bmi088}}"},
    Example{"decoder: openimu300", "imu: {can: {decoder: openimu300}}"},
    Example{"decoder: dronecan", "imu: {can: {decoder: dronecan}}"},
    Example{"decoder: dbc",
            "imu: {can: {decoder: dbc, dbc: none, map: {rate: {message: r, signals: [x, y, z]}, force: {message: f, "
            "signals: [x, y, z]}}}}"},
    Example{"iio", "imu: {iio: {device: imu}}"},
    Example{"serial", "imu: {serial: {protocol: vectornav}}"},
    Example{"mavlink", "imu: {mavlink: {}}"},
    Example{"ros2", "cameras: {ros2: {left: /left/image, right: /right/image}}"},
    Example{"ros2", "imu: {ros2: {topic: /imu}}"},
    Example{"gpio", "trigger_output: {gpio: {line: 0}}"},
    Example{"side_by_side", "cameras: {side_by_side: {}}"},
    Example{"signing", "sinks: {mavlink: {signing: {key_file: none}}}"},
};

/// A key as the reference prints it.
struct Entry {
    std::string field;
    std::string kind;  ///< which kind of vehicle has it, or has it so; empty: all
    YamlQuestion question;
};

/// Keys that are those of another place.
struct Alias {
    std::string_view begin;
    std::string_view stands_for;
};
constexpr std::array kAliases{
    Alias{"cameras.left.", "cameras."},
    Alias{"cameras.right.", "cameras."},
    Alias{"cameras.side_by_side.", "cameras."},
    Alias{"imu.spi.data_ready.", "trigger."},
    Alias{"trigger_output.gpio.", "trigger."},
    Alias{"realtime.threads.cameras.", "realtime.threads.estimator."},
    Alias{"realtime.threads.imu.", "realtime.threads.estimator."},
    Alias{"realtime.threads.trigger.", "realtime.threads.estimator."},
    Alias{"realtime.threads.output.", "realtime.threads.estimator."},
};

const VehicleKey* find_exactly(std::string_view field) {
    const auto keys = vehicle_keys();
    const auto found = std::ranges::find_if(keys, [&](const VehicleKey& key) { return field == key.field; });
    return found == keys.end() ? nullptr : &*found;
}

const VehicleKey* find_key(const std::string& field) {
    const VehicleKey* key = find_exactly(field);
    for (const Alias& alias : kAliases) {
        if (key == nullptr && field.starts_with(alias.begin)) {
            key = find_exactly(std::string(alias.stands_for) + field.substr(alias.begin.size()));
        }
    }
    return key;
}

/// Those of one camera that both may have in common are printed once.
bool is_repetition(const std::string& field) {
    return field.starts_with("cameras.") && std::ranges::count(field, '.') == 2 && find_exactly(field) == nullptr;
}

/// What several questions about one key say together.
void merge(const YamlQuestion& more, YamlQuestion& question) {
    question.is_required = question.is_required || more.is_required;
    question.fallback = question.fallback.empty() ? more.fallback : question.fallback;
    question.range = question.range.empty() ? more.range : question.range;
}

/// One entry for each key, and one more for each kind that has it otherwise.
std::vector<Entry> entries() {
    const Calibration calibration{};
    std::vector<Entry> all;
    for (const Example& example : kExamples) {
        std::vector<YamlQuestion> asked;
        {
            const YamlListener listener([&](const YamlQuestion& question) {
                const auto known = std::ranges::find(asked, question.field, &YamlQuestion::field);
                known == asked.end() ? asked.push_back(question) : merge(question, *known);
            });
            YAML::Node document = YAML::Load(kRestOfVehicle);
            for (const auto& item : YAML::Load(example.text)) {
                document[item.first.Scalar()] = item.second;
            }
            Vehicle vehicle;
            (void)check_vehicle(YamlNode(document, "", "", YamlNode::kNoLine), &calibration, vehicle);
            (void)check_vehicle(YamlNode(YAML::Load("calibration: {}"), "", "", YamlNode::kNoLine), nullptr, vehicle);
        }
        for (const YamlQuestion& question : asked) {
            const bool is_known = std::ranges::any_of(all, [&](const Entry& entry) {
                return entry.field == question.field && entry.question.range == question.range &&
                       entry.question.fallback == question.fallback;
            });
            if (!is_known && !is_repetition(question.field)) {
                all.push_back({question.field, example.kind, question});
            }
        }
    }
    return all;
}

std::size_t depth_of(const std::string& field) { return static_cast<std::size_t>(std::ranges::count(field, '.')); }

/// Appends a comment, broken into lines.
void add_comment(const std::string& text, std::size_t indent, std::string& out) {
    constexpr std::size_t kColumns = 118;
    const std::string begin = std::string(indent, ' ') + "#";
    std::string line = begin;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = std::min(text.find(' ', at), text.size());
        const std::string_view word = std::string_view(text).substr(at, end - at);
        if (line.size() + 1 + word.size() > kColumns && line != begin) {
            out += line + "\n";
            line = begin;
        }
        line += " ";
        line += word;
        at = end + 1;
    }
    out += line + "\n";
}

/// "Hz, [1, 200]. ", as far as there is something to say.
std::string facts(std::initializer_list<std::string> parts) {
    std::string text;
    for (const std::string& part : parts) {
        text += part.empty() ? "" : (text.empty() ? "" : ", ") + part;
    }
    return text.empty() ? "" : text + ". ";
}

void print_entry(const std::vector<Entry>& all, std::size_t at, std::string& out) {
    const Entry& entry = all[at];
    const std::string name = entry.field.substr(entry.field.rfind('.') + 1);
    const bool is_map =
        std::ranges::any_of(all, [&](const Entry& other) { return other.field.starts_with(entry.field + "."); });
    const bool is_second = std::ranges::find(all, entry.field, &Entry::field) - all.begin() < static_cast<long>(at);
    const std::size_t indent = 2 * depth_of(entry.field);
    const VehicleKey* const key = find_key(entry.field);
    out += indent == 0 && !out.empty() ? "\n" : "";
    const std::string kind = entry.kind.empty() ? "" : "with " + entry.kind;
    add_comment(facts({kind, entry.question.is_required ? "required" : "", key == nullptr ? "" : key->unit,
                       entry.question.range}) +
                    (key == nullptr ? "" : key->meaning),
                indent, out);
    const std::string value = is_map ? "" : " " + (entry.question.fallback.empty() ? "" : entry.question.fallback);
    out += fmt::format("{}{}{}:{}\n", std::string(indent, ' '), is_second ? "# " : "", name, value == " " ? "" : value);
}

/// Depth first, each level in the order in which the reader asks.
void print_below(const std::vector<Entry>& all, const std::string& parent, std::string& out) {
    for (std::size_t at = 0; at < all.size(); ++at) {
        const std::string& field = all[at].field;
        const std::size_t dot = field.rfind('.');
        const std::string above = dot == std::string::npos ? "" : field.substr(0, dot);
        if (above != parent) {
            continue;
        }
        print_entry(all, at, out);
        if (std::ranges::find(all, field, &Entry::field) - all.begin() == static_cast<long>(at)) {
            print_below(all, field, out);
        }
    }
}

}  // namespace

std::string vehicle_reference() {
    std::string out;
    print_below(entries(), "", out);
    return out;
}

std::string parameter_reference() {
    const ProgramConfig config{};
    std::string out;
    std::string_view section;
    for (const ConfigEntry& entry : config_table()) {
        if (entry.section != section) {
            out += fmt::format("{}{}:\n", out.empty() ? "" : "\n", entry.section);
            section = entry.section;
        }
        const std::string range = !entry.choices.empty() ? fmt::format("one of: {}", fmt::join(entry.choices, ", "))
                                  : entry.type == ParameterType::kBool ? "true or false"
                                                                       : fmt::format("[{}, {}]", entry.min, entry.max);
        const std::string unit = entry.unit == "-" ? "" : std::string(entry.unit);
        add_comment(facts({unit, range}) + std::string(entry.meaning), 2, out);
        out += fmt::format("  {}: {}\n", entry.name, value_text(entry, config));
    }
    return out;
}

std::vector<std::string> reference_gaps() {
    std::vector<std::string> gaps;
    const std::vector<Entry> all = entries();
    for (const Entry& entry : all) {
        if (find_key(entry.field) == nullptr) {
            gaps.push_back(entry.field + ": no sentence");
        }
    }
    for (const VehicleKey& key : vehicle_keys()) {
        if (std::ranges::find(all, key.field, &Entry::field) == all.end()) {
            gaps.push_back(std::string(key.field) + ": no such key");
        }
    }
    return gaps;
}

}  // namespace facet
