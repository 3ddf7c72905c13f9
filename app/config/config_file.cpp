// SPDX-License-Identifier: BSD-2-Clause
#include "app/config/config_file.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string_view>
#include <type_traits>

#include "app/config/config_table.h"
#include "app/support/input_error.h"
#include "app/support/yaml_file.h"

namespace facet {
namespace {

/// A level above known keys, e.g. "frontend".
bool is_section(const std::string& key) {
    const std::span<const ConfigEntry> table = config_table();
    return std::any_of(table.begin(), table.end(),
                       [&](const ConfigEntry& e) { return std::string_view(e.key).starts_with(key + "."); });
}

const ConfigEntry* find_entry(const std::string& key) {
    for (const ConfigEntry& entry : config_table()) {
        if (key == entry.key) {
            return &entry;
        }
    }
    return nullptr;
}

template <class T>
T read_value(const YamlNode& node, const ConfigEntry& entry) {
    double value = 0.0;
    T typed{};
    if constexpr (std::is_same_v<T, bool>) {
        if (!node.raw().IsScalar() || !YAML::convert<bool>::decode(node.raw(), typed)) {
            node.fail("must be true or false");
        }
        return typed;
    } else {
        value = node.number();
        if (std::is_integral_v<T> && value != std::floor(value)) {
            node.fail("must be an integer");
        }
        if (!(value >= entry.min && value <= entry.max)) {
            node.fail(fmt::format("must be within [{}, {}] {}, is {}", entry.min, entry.max, entry.unit, value));
        }
        return static_cast<T>(value);
    }
}

void read_entry(const YamlNode& node, const ConfigEntry& entry, ProgramConfig& config) {
    std::visit(
        [&](auto* field) {
            using T = std::remove_reference_t<decltype(field(config))>;
            field(config) = read_value<T>(node, entry);
        },
        entry.field);
}

void read_section(const YamlNode& section, ProgramConfig& config, std::set<std::string>& seen) {
    for (const auto& item : section.raw()) {
        const int line = item.first.Mark().line + 1;
        const std::string name = item.first.IsScalar() ? item.first.Scalar() : "?";
        const std::string key = section.field().empty() ? name : section.field() + "." + name;
        const YamlNode node(item.second, section.file(), key, line);
        if (const ConfigEntry* entry = find_entry(key)) {
            if (!seen.insert(key).second) {
                node.fail("given twice");
            }
            read_entry(node, *entry, config);
        } else if (!is_section(key)) {
            node.fail("unknown key");
        } else if (item.second.IsMap()) {
            read_section(node, config, seen);
        } else if (!item.second.IsNull()) {
            node.fail("must be a map of parameters");
        }
    }
}

std::string value_text(const ConfigEntry& entry, const ProgramConfig& config) {
    ProgramConfig copy = config;
    return std::visit([&](auto* field) { return fmt::format("{}", field(copy)); }, entry.field);
}

}  // namespace

void load_config(const std::string& path, ProgramConfig& config) {
    ProgramConfig loaded = config;
    std::set<std::string> seen;
    read_section(load_yaml(path), loaded, seen);
    config = loaded;
}

void set_config(const std::string& assignment, ProgramConfig& config) {
    const std::size_t equals = assignment.find('=');
    const std::string key = assignment.substr(0, equals);
    const ConfigEntry* entry = find_entry(key);
    if (equals == std::string::npos || entry == nullptr) {
        throw InputError(
            fmt::format("--set {}: {}", assignment, equals == std::string::npos ? "must be KEY=VALUE" : "unknown key"));
    }
    read_entry(YamlNode(YAML::Node(assignment.substr(equals + 1)), "--set", key, 1), *entry, config);
}

std::string print_config(const ProgramConfig& config) {
    std::string text;
    std::string section;
    for (const ConfigEntry& entry : config_table()) {
        const std::string_view key = entry.key;
        const std::size_t dot = key.rfind('.');
        if (key.substr(0, dot) != section) {
            section = key.substr(0, dot);
            text += section + ":\n";
        }
        const std::string setting = fmt::format("  {}: {}", key.substr(dot + 1), value_text(entry, config));
        text += fmt::format("{:<48} # {} [{}, {}] {}\n", setting, entry.unit, entry.min, entry.max, entry.meaning);
    }
    return text;
}

}  // namespace facet
