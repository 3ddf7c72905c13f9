// SPDX-License-Identifier: BSD-2-Clause
// Files that are compressed as a whole.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

namespace facet {

/// Whether the file begins as one of zstd does.
bool is_zstd_file(const std::string& path);

/// Writes what a file of zstd holds into another. Reentrant. Heap: some hundred kilobytes.
/// @param stop  ends it when it becomes true, what is written so far then being of no use; may be nullptr
/// @return what is wrong: a damaged frame, more than `most_bytes`, an error of reading or writing; empty if it has
///         been done, or ended
std::string decompress_file(const std::string& from, const std::string& to, std::uint64_t most_bytes,
                            const std::atomic<bool>* stop = nullptr);

}  // namespace facet
