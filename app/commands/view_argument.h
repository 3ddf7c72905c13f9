// SPDX-License-Identifier: BSD-2-Clause
// --view [ADDRESS:]PORT, --view-token FILE and --view-page FILE of run and replay.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "app/view/live_view.h"

namespace facet {

/// What the user typed.
struct ViewArguments {
    std::string place;  ///< empty: no view
    std::string token;  ///< name of its file
    std::string page;
};

void add_view_options(CLI::App& command, ViewArguments& arguments);

/// Begins to serve, and names the address on stderr; nullptr without --view. Throws InputError for a place
/// that is invalid, cannot be had, or needs a token, and for a token or a page without a place or that cannot be
/// read.
std::unique_ptr<LiveView> open_view(const ViewArguments& arguments, const StereoRig& rig);

/// One line on stdout for the end of a run.
void print_view(const ViewAccount& account);

}  // namespace facet
