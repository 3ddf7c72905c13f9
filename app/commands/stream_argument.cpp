// SPDX-License-Identifier: BSD-2-Clause
#include "app/commands/stream_argument.h"

#include <fmt/core.h>

#include "app/support/input_error.h"

namespace facet {

std::unique_ptr<WorldServer> open_stream(const std::string& path, const WorldAccess& access, const char* name) {
    if (path.empty()) {
        return nullptr;
    }
    auto server = std::make_unique<WorldServer>();
    switch (server->open(path, access)) {
        case Status::kOk: return server;
        case Status::kInvalidArgument: throw InputError(fmt::format("{} {}: the path is too long", name, path));
        case Status::kFull: throw InputError(fmt::format("{} {}: in use, or no socket", name, path));
        case Status::kNotFound: throw InputError(fmt::format("{} {}: there is no group {}", name, path, access.group));
        default:
            throw InputError(fmt::format("{} {}: cannot be opened as a local socket{}", name, path,
                                         access.group.empty() ? "" : ", or not given to the group " + access.group));
    }
}

}  // namespace facet
