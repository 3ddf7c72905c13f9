// SPDX-License-Identifier: BSD-2-Clause
// Files that are safe to read as a whole.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <system_error>

namespace facet {

/// Why this path is not to be read: a pipe would wait for its writer, a device never end, and a file of more than
/// `max_bytes` fill the memory; a directory opens like a file and fails, or throws, when it is read. Empty if it can be
/// read, or is not there, which opening it will tell. Reentrant. Heap.
inline std::string refuse_file(const std::string& path,
                               std::uintmax_t max_bytes = std::numeric_limits<std::uintmax_t>::max()) {
    namespace fs = std::filesystem;
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (!fs::exists(status)) {
        return {};
    }
    if (fs::is_directory(status)) {
        return "is a directory";
    }
    if (!fs::is_regular_file(status)) {
        return "is not a regular file";
    }
    const std::uintmax_t size = fs::file_size(path, error);
    if (error || size <= max_bytes) {
        return {};
    }
    return "has " + std::to_string(size >> 20U) + " MiB, more than the " + std::to_string(max_bytes >> 20U) +
           " that are read";
}

}  // namespace facet
