// SPDX-License-Identifier: BSD-2-Clause
// facet calibrate: refines the calibration from an ordinary flight.
#pragma once

namespace CLI {
class App;
}

namespace facet {

/// Adds the command. When it is run, exit_code becomes 0 (done), 1 (ran but failed its purpose) or 2 (bad input, or
/// built without its solver).
void add_calibrate_command(CLI::App& app, int& exit_code);

}  // namespace facet
