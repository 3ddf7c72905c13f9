// SPDX-License-Identifier: BSD-2-Clause
// facet check-calibration: says in words whether a log's calibration can be right.
#pragma once

namespace CLI {
class App;
}

namespace facet {

/// Adds the command. When it is run, exit_code becomes 0 (nothing wrong), 1 (something is) or 2 (bad input).
void add_check_calibration_command(CLI::App& app, int& exit_code);

}  // namespace facet
