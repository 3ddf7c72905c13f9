// SPDX-License-Identifier: BSD-2-Clause
// facet convert: logs from one form into another.
#pragma once

namespace CLI {
class App;
}

namespace facet {

/// Adds the command. When it is run, exit_code becomes 0 (done), 1 (interrupted) or 2 (bad input).
void add_convert_command(CLI::App& app, int& exit_code);

}  // namespace facet
