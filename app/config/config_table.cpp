// SPDX-License-Identifier: BSD-2-Clause
#include "app/config/config_table.h"

#include <fmt/core.h>

#include <cstdint>

#include "app/support/yaml_file.h"
#include "platform/base/range_check.h"

namespace facet {

const std::vector<ConfigEntry>& config_table() {
    static const std::vector<ConfigEntry> kTable = [] {
        std::vector<ConfigEntry> entries;
        for_each_section([&](const char* name, auto section, const auto& fields) {
            for (const auto& field : fields) {
                entries.push_back(
                    {.section = name,
                     .name = field.name,
                     .type = field.type(),
                     .unit = field.unit,
                     .min = field.min,
                     .max = field.max,
                     .meaning = field.meaning,
                     .choices = field.choices,
                     .value = [=](const ProgramConfig& config) { return field.value(config.*section); },
                     .set = [=](ProgramConfig& config, double value) { field.set(config.*section, value); }});
            }
        });
        return entries;
    }();
    return kTable;
}

std::string value_text(const ConfigEntry& entry, const ProgramConfig& config) {
    const double value = entry.value(config);
    if (!entry.choices.empty() && in_range(value, 0.0, static_cast<double>(entry.choices.size() - 1))) {
        return std::string(entry.choices[static_cast<std::size_t>(value)]);
    }
    switch (entry.type) {
        case ParameterType::kBool: return value != 0.0 ? "true" : "false";
        case ParameterType::kInteger: return fmt::format("{}", static_cast<std::int64_t>(value));
        case ParameterType::kReal: break;
    }
    return fmt::format("{}", value);
}

std::map<std::string, std::string> changed_parameters(const ProgramConfig& config) {
    const ProgramConfig defaults;
    std::map<std::string, std::string> changed;
    for (const ConfigEntry& entry : config_table()) {
        if (entry.value(config) != entry.value(defaults)) {
            changed[entry.key()] = value_text(entry, config);
        }
    }
    return changed;
}

std::string describe_fault(const ProgramConfig& config) {
    for (const ConfigEntry& entry : config_table()) {
        if (!in_range(entry.value(config), entry.min, entry.max)) {
            return fmt::format("{}: {}", entry.key(),
                               out_of_range_text(value_text(entry, config), entry.min, entry.max, entry.unit));
        }
    }
    std::string fault;
    for_each_section([&](const char* name, auto section, const auto& /*fields*/) {
        const std::string_view rule = broken_rule_of(config.*section);
        if (fault.empty() && !rule.empty()) {
            fault = fmt::format("{}: {}", name, rule);
        }
    });
    return fault;
}

}  // namespace facet
