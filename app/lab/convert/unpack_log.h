// SPDX-License-Identifier: BSD-2-Clause
// Makes the log folder again of which pack_log has made an MCAP file.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>

#include "app/lab/convert/mcap_log.h"

namespace facet {

struct UnpackAccount {
    std::uint64_t files = 0;
    std::uint64_t images = 0;
};

/// Writes every file of the log below a folder, which is made and must be empty, and nothing outside it.
/// @param progress  called after each image with the number written
/// Throws InputError naming the path if the folder is not empty or a file cannot be written; what is there stays.
UnpackAccount unpack_log(McapLog& log, const std::string& folder, const std::function<void(std::uint64_t)>& progress,
                         const std::atomic<bool>& stop);

/// Makes a folder that must be new or empty. Throws InputError otherwise.
void make_empty_folder(const std::string& folder);

/// Writes a file at once, folders included. Throws InputError naming the path.
void write_whole_file(const std::string& path, std::span<const std::uint8_t> bytes);

}  // namespace facet
