// SPDX-License-Identifier: BSD-2-Clause
// The command `facet sim`.
#pragma once

#include <CLI/CLI.hpp>

namespace facet {

/// Adds the subcommand `sim`. When it has run, exit_code is 0 (done) or 2 (bad usage, or a file could not be written),
/// the latter with one line on stderr. Both references must live until parsing is over.
void add_sim_command(CLI::App& app, int& exit_code);

}  // namespace facet
