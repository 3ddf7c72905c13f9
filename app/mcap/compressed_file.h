// SPDX-License-Identifier: BSD-2-Clause
// Files that are compressed as a whole.
#pragma once

#include <string>

namespace facet {

/// Whether the file begins as one of zstd does.
bool is_zstd_file(const std::string& path);

/// Writes what a file of zstd holds into another. Reentrant. Heap: some hundred kilobytes.
/// @return what is wrong: a damaged frame, an error of reading or writing; empty if it has been done
std::string decompress_file(const std::string& from, const std::string& to);

}  // namespace facet
