// SPDX-License-Identifier: BSD-2-Clause
// A run's status as text.
#pragma once

#include <string>

#include "app/run/live_run.h"

namespace facet {

/// One screen of lines, for a terminal that is redrawn. Reentrant.
std::string status_screen(const RunStatus& status, const std::string& title);
/// One line, for logs and for systemd. Reentrant.
std::string status_line(const RunStatus& status);

}  // namespace facet
