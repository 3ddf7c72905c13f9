// SPDX-License-Identifier: BSD-2-Clause
// Makes one MCAP file of a log folder.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <string>

#include "app/mcap/compression.h"

namespace facet {

struct PackOptions {
    std::string folder;  ///< EuRoC/ASL, with mav0 or without
    std::string file;    ///< to be written; an older one is replaced at the end
    Compression compression = Compression::kZstd;
    std::string library;  ///< who writes, for people
    /// Called after each message with how far the work is, in stamps of the log, from 0 to 1.
    std::function<void(double)> progress;
    std::function<void(const std::string&)> warn;
};

struct PackAccount {
    std::array<std::uint64_t, 4> messages{};  ///< by LogTable
    std::uint64_t attachments = 0;
};

/// Rows of data.csv become messages in the order of their stamps (log_messages.h), images among them; all other files
/// of the folder, calibration foremost, become attachments under their paths in it. A table that its messages alone do
/// not make again byte for byte (comments among the rows, missing images, numbers that JSON does not know) is attached
/// as well, and what it could not give goes without message, so that McapLog gives every file of the folder back as it
/// was. Folders without files, and what is no regular file, are left out. Memory: the names of the images.
/// Throws InputError if the folder has no log, a file cannot be read, or the MCAP file cannot be written.
/// @return what is in the file; nothing if `stop` was set, and then there is no file
PackAccount pack_log(const PackOptions& options, const std::atomic<bool>& stop);

}  // namespace facet
