// SPDX-License-Identifier: BSD-2-Clause
// facet record: live sensors into a log.
#pragma once

namespace CLI {
class App;
}

namespace facet {

/// Adds the command. When it is run, exit_code becomes 0 (stopped in order), 1 (nothing, or not all, was recorded) or 2
/// (bad input, or hardware that is not there).
void add_record_command(CLI::App& app, int& exit_code);

}  // namespace facet
