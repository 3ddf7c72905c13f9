// SPDX-License-Identifier: BSD-2-Clause
// Where the files of a log are read from, if not from the disk.
#pragma once

#include <cstddef>
#include <cstdint>
#include <istream>
#include <memory>
#include <string>
#include <vector>

namespace facet {

/// Files of a log that lie in something else than folders. Paths are those that the reader would use on the disk.
/// Thread-bound. Heap.
class LogFiles {
public:
    LogFiles() = default;
    virtual ~LogFiles() = default;
    LogFiles(const LogFiles&) = delete;
    LogFiles& operator=(const LogFiles&) = delete;

    virtual bool has_folder(const std::string& path) = 0;
    /// @return nullptr if there is no such file; else a stream that is valid as long as this object
    virtual std::unique_ptr<std::istream> open(const std::string& path) = 0;
    /// Replaces `bytes` by a whole file. @return why it cannot be read; empty if it has been
    virtual std::string read(const std::string& path, std::size_t most_bytes, std::vector<std::uint8_t>& bytes) = 0;
};

}  // namespace facet
