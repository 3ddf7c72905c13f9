// SPDX-License-Identifier: BSD-2-Clause
#include "app/commands/info_command.h"

#include <fmt/format.h>
#include <malloc.h>
#include <png.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/commands/build_info.h"
#include "app/commands/build_version.h"
#include "app/commands/help_formatter.h"
#include "app/commands/run_guarded.h"
#include "app/config/config_file.h"
#include "app/lab/faults/fault.h"
#include "app/lab/sim/default_rig.h"
#include "app/support/console.h"
#include "estimator/api/estimator.h"
#include "estimator/values/capacity.h"
#include "mesh/mesher.h"
#include "mesh/planes/plane_finder.h"

namespace facet {
namespace {

void print_build() {
    print_out("{}\n", build_version());
    print_out(
        "libraries    Eigen {}, Boost {}, libpng {}, yaml-cpp {}, fmt {}.{}.{}, nlohmann-json {}.{}.{}, "
        "CLI11 {}\n",
        build_info::kEigen, build_info::kBoost, PNG_LIBPNG_VER_STRING, build_info::kYamlCpp, FMT_VERSION / 10000,
        FMT_VERSION / 100 % 100, FMT_VERSION % 100, NLOHMANN_JSON_VERSION_MAJOR, NLOHMANN_JSON_VERSION_MINOR,
        NLOHMANN_JSON_VERSION_PATCH, CLI11_VERSION);
    print_out(
        "capacities   {} features per frame, {} keyframes, {} landmarks, {} planes, {} inertial samples between "
        "keyframes\n",
        kMaxFeatures, kMaxKeyframes, kMaxLandmarks, kMaxPlanes, kMaxImuSamples);
    print_out("modes        {}\n", fmt::join(kRegularityModeNames, ", "));
}

/// Heap in use by this process.
std::size_t heap_bytes() {
    const struct mallinfo2 info = mallinfo2();
    return info.uordblks + info.hblkhd;
}

/// What estimator, mesher and plane finder hold once configured for the EuRoC rig.
void print_memory() {
    constexpr double kMegabyte = 1e6;
    const StereoRig rig = sim::euroc_rig();
    const std::size_t before = heap_bytes();
    Estimator estimator;
    const bool is_configured = ok(estimator.configure({}, rig));
    const auto mesher = std::make_unique<Mesher>();
    const auto planes = std::make_unique<PlaneFinder>();
    const std::size_t all = heap_bytes() - before;
    FACET_ASSERT(is_configured && all <= kMemoryBudget);
    std::size_t known = sizeof(Mesher) + sizeof(PlaneFinder);
    print_out("memory       {:.2f} MB, all taken before the first sample:", static_cast<double>(all) / kMegabyte);
    for (const MemoryPart& part : Estimator::memory()) {
        print_out(" {} {:.2f},", part.name, static_cast<double>(part.bytes) / kMegabyte);
        known += part.bytes;
    }
    print_out(" mesher {:.2f}, plane finder {:.2f}, buffers for {}x{} images {:.2f}\n", sizeof(Mesher) / kMegabyte,
              sizeof(PlaneFinder) / kMegabyte, rig.left.intrinsics().width, rig.left.intrinsics().height,
              static_cast<double>(all - known) / kMegabyte);
}

}  // namespace

void add_info_command(CLI::App& app, int& exit_code) {
    CLI::App* command =
        app.add_subcommand("info", "Print version, build, library versions, capacities and default parameters");
    auto only_config = std::make_shared<bool>(false);
    command->add_flag("--config", *only_config, "Print only the default parameters, as a YAML file for --config");
    auto only_faults = std::make_shared<bool>(false);
    command->add_flag("--faults", *only_faults, "Print only the faults that facet replay --inject knows");
    command->callback([only_config, only_faults, &exit_code] {
        exit_code = run_guarded([&] {
            if (*only_faults) {
                print_out("{}\n", fit_help(fault_help()));
                return kExitDone;
            }
            if (!*only_config) {
                print_build();
                print_memory();
                print_out("\n");
            }
            print_out("# Parameters with their defaults: unit, range, meaning.\n{}", print_config(ProgramConfig{}));
            return kExitDone;
        });
    });
}

}  // namespace facet
