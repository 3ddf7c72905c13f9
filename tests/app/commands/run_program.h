// SPDX-License-Identifier: BSD-2-Clause
// The program as a user runs it, and what it says.
#pragma once

#include <cstddef>
#include <string>

#include "tests/support/temp_dir.h"

namespace facet::test {

struct Outcome {
    int code = -1;  ///< -1 if a signal ended it
    std::string out;
    std::string err;
};

/// Runs the program with these arguments, as the shell understands them; what it says goes through files in `dir`.
Outcome run(const TempDir& dir, const std::string& arguments);

/// Runs a command line of a shell in `dir`, with $FACET for the program. @return its exit code, -1 after a signal
int shell(const TempDir& dir, const std::string& line);

bool contains(const std::string& text, const std::string& part);

std::size_t count_lines(const std::string& text);

}  // namespace facet::test
