// SPDX-License-Identifier: BSD-2-Clause
// The program's exit codes, and the place where exceptions end.
#pragma once

#include <functional>

namespace facet {

inline constexpr int kExitDone = 0;
inline constexpr int kExitFailed = 1;    ///< ran but failed its purpose
inline constexpr int kExitBadInput = 2;  ///< bad usage or input, one clear line on stderr

/// Runs a command's body and returns its exit code. InputError becomes one line and kExitBadInput, any other exception
/// one line and kExitFailed.
int run_guarded(const std::function<int()>& body);

/// Prints "facet: error: message" on stderr.
void print_error(const char* message);

}  // namespace facet
