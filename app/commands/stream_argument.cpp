// SPDX-License-Identifier: BSD-2-Clause
#include "app/commands/stream_argument.h"

#include <fmt/core.h>

#include "app/support/input_error.h"

namespace facet {

std::unique_ptr<WorldServer> open_stream(const std::string& path) {
    if (path.empty()) {
        return nullptr;
    }
    auto server = std::make_unique<WorldServer>();
    switch (server->open(path)) {
        case Status::kOk: return server;
        case Status::kInvalidArgument: throw InputError(fmt::format("--stream {}: the path is too long", path));
        case Status::kFull: throw InputError(fmt::format("--stream {}: in use, or no socket", path));
        default: throw InputError(fmt::format("--stream {}: cannot be opened as a local socket", path));
    }
}

}  // namespace facet
