// SPDX-License-Identifier: BSD-2-Clause
// The system calls that drivers make, as an interface: the kernel on the target, a scripted kernel in tests.
#pragma once

#include <cstddef>
#include <cstdint>

#include "platform/base/timestamp.h"

struct msghdr;

namespace facet {

/// The calls of POSIX and Linux with their meaning there, but with failures as negative errno values and EINTR handled
/// inside. Who calls has the context and reports. Thread-safe as the kernel is. No heap.
class KernelIo {
public:
    virtual ~KernelIo() = default;

    /// @return a descriptor or -errno. O_CLOEXEC is always added.
    virtual int open(const char* path, int flags) = 0;
    virtual int close(int fd) = 0;
    virtual int ioctl(int fd, unsigned long request, void* argument) = 0;
    virtual std::int64_t read(int fd, void* buffer, std::size_t size) = 0;
    virtual std::int64_t write(int fd, const void* buffer, std::size_t size) = 0;
    /// Some of the entries of an open folder, as records of getdents64(2); then the next ones.
    /// @return bytes, 0 after the last entry, or -errno
    virtual std::int64_t read_folder(int fd, void* entries, std::size_t size) = 0;
    /// Waits until a read, or a dequeue, would not block or would fail.
    /// @param timeout  zero: do not wait
    /// @return 1 if so, 0 after the timeout, -errno
    virtual int wait_readable(int fd, Duration timeout) = 0;
    /// Numbers of the device that an open node is of, whatever the names that lead to it.
    /// @return 0 with `major` and `minor` set, or -errno
    virtual int device_number(int fd, unsigned& major, unsigned& minor) = 0;

    /// Maps length bytes shared, for reading and writing. @return 0 with `address` set, or -errno.
    virtual int map(int fd, std::size_t length, std::int64_t offset, void*& address) = 0;
    virtual int unmap(void* address, std::size_t length) = 0;

    /// @return a descriptor or -errno.
    virtual int socket(int domain, int type, int protocol) = 0;
    virtual int bind(int fd, const void* address, std::size_t size) = 0;
    virtual int connect(int fd, const void* address, std::size_t size) = 0;
    virtual int set_option(int fd, int level, int name, const void* value, std::size_t size) = 0;
    /// recvmsg. @return bytes received or -errno.
    virtual std::int64_t receive(int fd, ::msghdr& message) = 0;
};

}  // namespace facet
