// SPDX-License-Identifier: BSD-2-Clause
// A file that grows by whole pieces and is on the disk at every commit.
#pragma once

#include <sys/types.h>

#include <string>
#include <string_view>
#include <vector>

namespace facet {

/// A new file that has its name from the first moment on. Pieces reach it whole: what a write leaves of one that did
/// not fit is cut off again. The constructor, which overwrites no file, and commit() throw InputError naming the path.
/// Thread-bound. Heap.
class AppendFile {
public:
    explicit AppendFile(std::string path);
    ~AppendFile();
    AppendFile(const AppendFile&) = delete;
    AppendFile& operator=(const AppendFile&) = delete;

    /// Keeps a piece until commit().
    void add(std::string_view piece);
    /// Brings the pieces to the disk.
    void commit();

private:
    [[noreturn]] void fail(int error) const;
    std::size_t whole_pieces(std::size_t written) const;

    std::string path_;
    std::string pending_;
    std::vector<std::size_t> ends_;  ///< of the pieces in it
    off_t size_ = 0;                 ///< of the whole pieces in the file
    int descriptor_ = -1;
};

}  // namespace facet
