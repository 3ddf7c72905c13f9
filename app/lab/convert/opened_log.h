// SPDX-License-Identifier: BSD-2-Clause
// A log that a user names: a folder, or an MCAP file made of one.
#pragma once

#include <memory>
#include <string>

#include "app/calibration/calibration.h"
#include "app/lab/mcap/mcap_file.h"
#include "drivers/replay_asl/log_files.h"

namespace facet {

/// Images and inertial samples of an MCAP file are read where they are; its small files (calibration, ground truth) are
/// written into a temporary folder, which goes with the object. Thread-bound. Heap.
class OpenedLog {
public:
    /// Throws InputError if it is neither a log folder nor an MCAP file of one, or the temporary folder cannot be made.
    /// @param warn  of an MCAP file; called also later, while the log is read
    OpenedLog(const std::string& path, const McapFile::Warn& warn);
    ~OpenedLog();
    OpenedLog(const OpenedLog&) = delete;
    OpenedLog& operator=(const OpenedLog&) = delete;

    /// For AslOptions: nullptr if the log is a folder.
    LogFiles* files() const { return files_.get(); }
    /// A folder on the disk with the log's calibration, ground truth and true scene; the log itself if it is a folder.
    const std::string& folder() const { return folder_; }
    /// The folder in there that holds cam0.
    const std::string& root() const { return root_; }

private:
    void extract(const std::string& path, const McapFile::Warn& warn);

    std::unique_ptr<LogFiles> files_;
    std::string temporary_;  ///< empty: none
    std::string folder_;
    std::string root_;
};

/// Size of the first left image of a log that can be read; zero if none can, or it is no log.
/// @param files  as OpenedLog has them
ImageExtent extent_of_images(const std::string& path, LogFiles* files);

}  // namespace facet
