// SPDX-License-Identifier: BSD-2-Clause
// The one table of all parameters: loading, printing and validation all run from it.
#pragma once

#include <cstdint>
#include <span>
#include <variant>

#include "app/config/program_config.h"

namespace facet {

/// Access to one field of an ProgramConfig.
using ConfigField = std::variant<int& (*)(ProgramConfig&), std::uint32_t& (*)(ProgramConfig&),
                                 double& (*)(ProgramConfig&), bool& (*)(ProgramConfig&)>;

/// One parameter. A bool has min 0 and max 1.
struct ConfigEntry {
    const char* key;  ///< as in the YAML file, dots between levels
    ConfigField field;
    const char* unit;  ///< "-" if none
    double min;
    double max;
    const char* meaning;
};

/// All parameters, in the order in which they are printed. Entries live for ever.
std::span<const ConfigEntry> config_table();

/// Value as a number, whatever its type.
double config_value(const ConfigEntry& entry, const ProgramConfig& config);

/// First entry whose value is not within [min, max] or not finite; nullptr if all are.
const ConfigEntry* find_out_of_range(const ProgramConfig& config);

}  // namespace facet
