// SPDX-License-Identifier: BSD-2-Clause
// facet report: one page of the results of runs.
#pragma once

namespace CLI {
class App;
}

namespace facet {

/// Adds the command, which becomes scripts/report: that of the source tree which the program was built in, or the one
/// that is installed with it. The page is Python's work (docs/decisions/system.md). When it is run, the process
/// ends with the script's exit code; exit_code becomes 2 if there is no script or no Python.
void add_report_command(CLI::App& app, int& exit_code);

}  // namespace facet
