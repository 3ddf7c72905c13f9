// SPDX-License-Identifier: BSD-2-Clause
#include "app/config/config_file.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string_view>

#include "app/config/config_table.h"
#include "app/support/input_error.h"
#include "app/support/yaml_file.h"

namespace facet {
namespace {

/// A level above known keys, e.g. "frontend".
bool is_section(const std::string& key) {
    return std::ranges::find(config_table(), key, &ConfigEntry::section) != config_table().end();
}

const ConfigEntry* find_entry(const std::string& key) {
    const auto at = std::ranges::find(config_table(), key, &ConfigEntry::key);
    return at == config_table().end() ? nullptr : &*at;
}

void read_entry(const YamlNode& node, const ConfigEntry& entry, ProgramConfig& config) {
    if (entry.type == ParameterType::kBool) {
        entry.set(config, node.boolean() ? 1.0 : 0.0);
        return;
    }
    if (!entry.choices.empty()) {
        entry.set(config, static_cast<double>(node.choice(entry.choices)));
        return;
    }
    const double value = node.number();
    if (entry.type == ParameterType::kInteger && value != std::floor(value)) {
        node.fail("must be an integer");
    }
    node.require_in_range(value, entry.min, entry.max, entry.unit);
    entry.set(config, value);
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

}  // namespace

void load_config(const std::string& path, ProgramConfig& config) {
    ProgramConfig loaded = config;
    std::set<std::string> seen;
    read_section(load_yaml(path), loaded, seen);
    config = loaded;
}

void set_config(const std::string& assignment, ProgramConfig& config) {
    const std::string option = "--set " + assignment;
    const std::size_t equals = assignment.find('=');
    if (equals == std::string::npos) {
        throw InputError(option + ": must be KEY=VALUE");
    }
    const ConfigEntry* entry = find_entry(assignment.substr(0, equals));
    if (entry == nullptr) {
        throw InputError(option + ": unknown key");
    }
    read_entry(YamlNode(YAML::Node(assignment.substr(equals + 1)), option, "", YamlNode::kNoLine), *entry, config);
}

std::string print_config(const ProgramConfig& config) {
    std::string text;
    std::string_view section;
    for (const ConfigEntry& entry : config_table()) {
        if (entry.section != section) {
            section = entry.section;
            text += entry.section + ":\n";
        }
        const std::string setting = fmt::format("  {}: {}", entry.name, value_text(entry, config));
        const std::string range = entry.choices.empty() ? fmt::format("[{}, {}]", entry.min, entry.max)
                                                        : fmt::format("[{}]", fmt::join(entry.choices, ", "));
        text += fmt::format("{:<48} # {} {} {}\n", setting, entry.unit, range, entry.meaning);
    }
    return text;
}

}  // namespace facet
