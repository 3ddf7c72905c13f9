// SPDX-License-Identifier: BSD-2-Clause
// facet run: estimates from live sensors.
#pragma once

namespace CLI {
class App;
}

namespace facet {

/// Adds the command. When it is run, exit_code becomes 0 (stopped in order), 1 (ran but failed its purpose) or 2 (bad
/// input, or hardware that is not there).
void add_run_command(CLI::App& app, int& exit_code);

}  // namespace facet
