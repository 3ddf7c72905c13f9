// SPDX-License-Identifier: BSD-2-Clause
// Reads a text file whole, whichever program has saved it.
#pragma once

#include <string>

namespace facet {

/// A file of at most 4 MiB. A byte order mark is left out; UTF-16, which PowerShell and Notepad write, becomes ASCII
/// with '?' for whatever else it has. Throws InputError if it cannot be read, is no regular file or is longer.
std::string read_whole_text(const std::string& path);

}  // namespace facet
