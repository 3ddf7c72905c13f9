// SPDX-License-Identifier: BSD-2-Clause
// facet check-config: says whether a vehicle file can be used, and what is wrong with it.
#pragma once

namespace CLI {
class App;
}

namespace facet {

/// Adds the command. When it is run, exit_code becomes 0 (it can be used) or 2 (it cannot).
void add_check_config_command(CLI::App& app, int& exit_code);

}  // namespace facet
