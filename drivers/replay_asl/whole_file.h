// SPDX-License-Identifier: BSD-2-Clause
// Files that are read at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace facet {

/// Reads a regular file of up to most_bytes; `bytes` only grows, and its first `size` ones are the file's. Reentrant.
/// @return false with `error` saying why it cannot be read
bool read_whole_file(const std::string& path, std::size_t most_bytes, std::vector<std::uint8_t>& bytes,
                     std::size_t& size, std::string& error);

}  // namespace facet
