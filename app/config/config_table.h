// SPDX-License-Identifier: BSD-2-Clause
// All parameters of the program, as the tables of its configuration structs describe them.
#pragma once

#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app/config/program_config.h"

namespace facet {

/// Calls visit(name, section, fields) for every section of a configuration file, in the order in which they are
/// printed: its name, the pointer to its struct in ProgramConfig, and the table of that struct.
template <class Visitor>
void for_each_section(Visitor&& visit) {
    visit("frontend", &ProgramConfig::frontend, kFrontendFields);
    visit("initializer", &ProgramConfig::initializer, kInitializerFields);
    visit("window", &ProgramConfig::window, kWindowFields);
    visit("regularity", &ProgramConfig::regularity, kRegularityFields);
    visit("range", &ProgramConfig::range, kRangeFields);
    visit("calibration", &ProgramConfig::calibration, kCalibrationFields);
    visit("health", &ProgramConfig::health, kHealthFields);
    visit("imu_limits", &ProgramConfig::imu_limits, kImuLimitFields);
    visit("imu_noise", &ProgramConfig::imu_noise, kImuNoiseFields);
    visit("gravity", &ProgramConfig::gravity, kGravityFields);
    visit("mesh", &ProgramConfig::mesh, kMeshFields);
    visit("planes", &ProgramConfig::planes, kPlaneFields);
    visit("grid", &ProgramConfig::grid, kGridFields);
    visit("map", &ProgramConfig::map, kMapFields);
}

/// One parameter: a ParameterField of any section.
struct ConfigEntry {
    std::string section;
    std::string_view name;
    ParameterType type = ParameterType::kReal;
    std::string_view unit;  ///< "-" if there is none
    double min = 0.0;
    double max = 0.0;
    std::string_view meaning;
    std::span<const std::string_view> choices;  ///< names of the values 0, 1, ...; empty: they have none
    std::function<double(const ProgramConfig&)> value;
    std::function<void(ProgramConfig&, double)> set;  ///< the value must be one that the type has

    /// As in a file, e.g. "frontend.max_features".
    std::string key() const { return section + "." + std::string(name); }
};

/// All parameters, in the order in which they are printed. Made once, at the first call. Thread-safe.
const std::vector<ConfigEntry>& config_table();

/// The value as it is written in a file.
std::string value_text(const ConfigEntry& entry, const ProgramConfig& config);

/// Keys and values, as in a file, of the parameters that differ from their defaults.
std::map<std::string, std::string> changed_parameters(const ProgramConfig& config);

/// Why a configuration is invalid, in one line: the first parameter outside its range, or else the first condition
/// between parameters that does not hold. Empty if it is valid.
std::string describe_fault(const ProgramConfig& config);

}  // namespace facet
