// SPDX-License-Identifier: BSD-2-Clause
#include "app/commands/build_version.h"

#include <fmt/core.h>

#include "app/commands/build_info.h"

namespace facet {

std::string build_version() {
    return fmt::format(
        "facet        {}\n"
        "commit       {}\n"
        "compiler     {}\n"
        "target       {}\n"
        "build        {}: {}",
        FACET_VERSION, build_commit(), build_info::kCompiler, build_info::kSystem, build_info::kBuildType,
        build_info::kFlags);
}

}  // namespace facet
