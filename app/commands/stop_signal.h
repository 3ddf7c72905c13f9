// SPDX-License-Identifier: BSD-2-Clause
// Ends a command in order when the user or the system asks for it.
#pragma once

#include <atomic>
#include <initializer_list>

namespace facet {

/// From here on the first of these signals sets the flag, which is returned; a second one ends the program at once.
const std::atomic<bool>& stop_on_signals(std::initializer_list<int> signals);

}  // namespace facet
