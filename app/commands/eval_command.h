// SPDX-License-Identifier: BSD-2-Clause
// facet eval: measures the accuracy of an estimated trajectory.
#pragma once

namespace CLI {
class App;
}

namespace facet {

/// Adds the command. When it is run, exit_code becomes 0 (done), 1 (ran but failed its purpose) or 2 (bad input).
void add_eval_command(CLI::App& app, int& exit_code);

}  // namespace facet
