// SPDX-License-Identifier: BSD-2-Clause
// At most one run writes into a folder.
#pragma once

#include <string>

namespace facet {

/// Holds a folder for one writer, other programs included, until it is destroyed or the program ends, however it ends.
/// No file is made. Where the file system cannot lock, nothing is held. Thread-bound.
class FolderLock {
public:
    /// Throws InputError if the folder is held already.
    /// @param folder  that exists
    explicit FolderLock(const std::string& folder);
    ~FolderLock();
    FolderLock(const FolderLock&) = delete;
    FolderLock& operator=(const FolderLock&) = delete;

private:
    int descriptor_;
};

}  // namespace facet
