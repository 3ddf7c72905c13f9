// SPDX-License-Identifier: BSD-2-Clause
#include "app/support/append_file.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "app/support/input_error.h"

namespace facet {

AppendFile::AppendFile(std::string path)
    : path_(std::move(path)), descriptor_(::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644)) {
    if (descriptor_ < 0) {
        fail(errno);
    }
}

AppendFile::~AppendFile() {
    if (descriptor_ >= 0) {
        ::close(descriptor_);
    }
}

void AppendFile::fail(int error) const {
    throw InputError(fmt::format("{}: cannot be written: {}", path_, std::strerror(error)));
}

void AppendFile::add(std::string_view piece) {
    pending_ += piece;
    ends_.push_back(pending_.size());
}

/// Bytes of the pieces that lie within those written.
std::size_t AppendFile::whole_pieces(std::size_t written) const {
    const auto behind = std::upper_bound(ends_.begin(), ends_.end(), written);
    return behind == ends_.begin() ? 0 : *std::prev(behind);
}

void AppendFile::commit() {
    std::size_t done = 0;
    while (done < pending_.size()) {
        const ssize_t count = ::write(descriptor_, pending_.data() + done, pending_.size() - done);
        if (count < 0 && errno == EINTR) {
            continue;
        }
        if (count <= 0) {
            const int error = errno;
            const std::size_t whole = whole_pieces(done);
            size_ += static_cast<off_t>(whole);
            pending_.erase(0, whole);
            std::erase_if(ends_, [&](std::size_t end) { return end <= whole; });
            for (std::size_t& end : ends_) {
                end -= whole;
            }
            (void)::ftruncate(descriptor_, size_);
            (void)::lseek(descriptor_, size_, SEEK_SET);
            fail(error);
        }
        done += static_cast<std::size_t>(count);
    }
    size_ += static_cast<off_t>(done);
    pending_.clear();
    ends_.clear();
    if (::fdatasync(descriptor_) != 0) {
        fail(errno);
    }
}

}  // namespace facet
