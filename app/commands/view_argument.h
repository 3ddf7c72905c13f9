// SPDX-License-Identifier: BSD-2-Clause
// --view PORT and --view-page FILE of run and replay.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "app/view/live_view.h"

namespace facet {

/// What the user typed.
struct ViewArguments {
    std::optional<std::uint16_t> port;
    std::string page;
};

void add_view_options(CLI::App& command, ViewArguments& arguments);

/// Begins to serve, and names the address on stderr; nullptr without --view. Throws InputError for a page without a
/// port, a page that cannot be read, or a port that cannot be had.
std::unique_ptr<LiveView> open_view(const ViewArguments& arguments, const StereoRig& rig);

/// One line on stdout for the end of a run.
void print_view(const ViewAccount& account);

}  // namespace facet
