// SPDX-License-Identifier: BSD-2-Clause
// facet calibration: says what a calibration file holds, and converts it.
#pragma once

namespace CLI {
class App;
}

namespace facet {

/// Adds the command. When it is run, exit_code becomes 0 (done) or 2 (bad input, or the output cannot be written).
void add_calibration_command(CLI::App& app, int& exit_code);

}  // namespace facet
