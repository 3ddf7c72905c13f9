// SPDX-License-Identifier: BSD-2-Clause
// --stream PATH of run and replay.
#pragma once

#include <memory>
#include <string>

#include "drivers/world_stream/world_server.h"

namespace facet {

inline constexpr const char* kStreamHelp =
    "Serve mesh, planes and grid at each keyframe on a local (unix) socket at this path, for planners; see "
    "drivers/world_stream";

/// nullptr if the path is empty. Throws InputError if nothing can be served there.
/// @param name  of the option or field, for the error
std::unique_ptr<WorldServer> open_stream(const std::string& path, const WorldAccess& access = {},
                                         const char* name = "--stream");

}  // namespace facet
