// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/replay_asl/whole_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace facet {
namespace {

/// An open file, closed when it goes.
struct OpenFile {
    // O_NONBLOCK: opening a pipe without a writer would wait for one.
    explicit OpenFile(const char* path) : descriptor(::open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {}
    ~OpenFile() {
        if (descriptor >= 0) {
            ::close(descriptor);
        }
    }
    OpenFile(const OpenFile&) = delete;
    OpenFile& operator=(const OpenFile&) = delete;

    int descriptor;
};

/// Why a file is not to be read: a pipe would wait, a device never end, and a file of gigabytes fill the memory.
bool refuse(const struct stat& status, std::size_t most_bytes, std::string& error) {
    if (S_ISDIR(status.st_mode)) {
        error = std::strerror(EISDIR);
    } else if (!S_ISREG(status.st_mode)) {
        error = "is not a regular file";
    } else if (static_cast<std::uintmax_t>(status.st_size) > most_bytes) {
        error = "has " + std::to_string(status.st_size >> 20U) + " MiB, more than the " +
                std::to_string(most_bytes >> 20U) + " that are read";
    } else {
        return false;
    }
    return true;
}

}  // namespace

bool read_whole_file(const std::string& path, std::size_t most_bytes, std::vector<std::uint8_t>& bytes,
                     std::size_t& size, std::string& error) {
    const OpenFile file(path.c_str());
    struct stat status {};
    if (file.descriptor < 0 || ::fstat(file.descriptor, &status) != 0) {
        error = std::strerror(errno);
        return false;
    }
    if (refuse(status, most_bytes, error)) {
        return false;
    }
    // A file that grows meanwhile is read as long as it was; one that shrinks ends too early, which its decoder says.
    const auto wanted = static_cast<std::size_t>(status.st_size);
    if (bytes.size() < wanted) {
        bytes.resize(wanted);
    }
    for (size = 0; size < wanted;) {
        const ssize_t got = ::read(file.descriptor, bytes.data() + size, wanted - size);
        if (got < 0 && errno == EINTR) {
            continue;
        }
        if (got < 0) {
            error = std::strerror(errno);
            return false;
        }
        if (got == 0) {
            break;
        }
        size += static_cast<std::size_t>(got);
    }
    return true;
}

}  // namespace facet
