// SPDX-License-Identifier: BSD-2-Clause
// Loads and prints the estimator's parameters as YAML.
#pragma once

#include <string>

#include "app/config/program_config.h"

namespace facet {

/// Overwrites in `config` what a YAML file gives; keys that are missing stay as they are. Levels may be nested maps or
/// dotted keys. Throws InputError, one line with file, line and key, for an unknown key, a wrong type or a value out of
/// range (with value and range); `config` is then untouched. Conditions between parameters are not checked here:
/// settings that follow may still fulfil them. See describe_fault.
void load_config(const std::string& path, ProgramConfig& config);

/// Sets one parameter from "key=value". Throws InputError for the same reasons, naming the option --set with its value.
void set_config(const std::string& assignment, ProgramConfig& config);

/// All parameters as a YAML document, each with unit, range and meaning in a comment. load_config reads it back.
std::string print_config(const ProgramConfig& config);

}  // namespace facet
