// SPDX-License-Identifier: BSD-2-Clause
// facet map: what a file of remembered places holds.
#pragma once

namespace CLI {
class App;
}

namespace facet {

/// Adds the subcommand; its callback runs it and sets exit_code.
void add_map_command(CLI::App& app, int& exit_code);

}  // namespace facet
