// SPDX-License-Identifier: BSD-2-Clause
#include "app/commands/info_command.h"

#include <fmt/core.h>
#include <png.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/commands/build_info.h"
#include "app/commands/run_guarded.h"
#include "app/config/config_file.h"
#include "estimator/api/capacity.h"

namespace facet {
namespace {

void print_build() {
    fmt::print("facet        {}\n", FACET_VERSION);
    fmt::print("compiler     {}\n", build_info::kCompiler);
    fmt::print("target       {}\n", build_info::kSystem);
    fmt::print("build        {}: {}\n", build_info::kBuildType, build_info::kFlags);
    fmt::print(
        "libraries    Eigen {}, OpenCV {}, Boost {}, libpng {}, yaml-cpp {}, fmt {}.{}.{}, nlohmann-json {}.{}.{}, "
        "CLI11 {}\n",
        build_info::kEigen, build_info::kOpenCv, build_info::kBoost, PNG_LIBPNG_VER_STRING, build_info::kYamlCpp,
        FMT_VERSION / 10000, FMT_VERSION / 100 % 100, FMT_VERSION % 100, NLOHMANN_JSON_VERSION_MAJOR,
        NLOHMANN_JSON_VERSION_MINOR, NLOHMANN_JSON_VERSION_PATCH, CLI11_VERSION);
    fmt::print(
        "capacities   {} features a frame, {} keyframes, {} landmarks, {} planes, {} inertial samples between "
        "keyframes\n",
        kMaxFeatures, kMaxKeyframes, kMaxLandmarks, kMaxPlanes, kMaxImuSamples);
    fmt::print("modes        s, sp, spr\n");
}

}  // namespace

void add_info_command(CLI::App& app, int& exit_code) {
    CLI::App* command =
        app.add_subcommand("info", "Print version, build, library versions, capacities and default parameters");
    auto only_config = std::make_shared<bool>(false);
    command->add_flag("--config", *only_config, "Print only the default parameters, as a YAML file for --config");
    command->callback([only_config, &exit_code] {
        exit_code = run_guarded([&] {
            if (!*only_config) {
                print_build();
                fmt::print("\n");
            }
            fmt::print("# Parameters with their defaults: unit, range, meaning.\n{}", print_config(ProgramConfig{}));
            return kExitDone;
        });
    });
}

}  // namespace facet
