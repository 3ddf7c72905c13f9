// SPDX-License-Identifier: BSD-2-Clause
// The system calls of Linux.
#pragma once

#include "platform/port/kernel_io.h"

namespace facet {

/// Passes every call on to the kernel. Thread-safe. No heap.
class LinuxKernelIo final : public KernelIo {
public:
    int open(const char* path, int flags) override;
    int close(int fd) override;
    int ioctl(int fd, unsigned long request, void* argument) override;
    std::int64_t read(int fd, void* buffer, std::size_t size) override;
    std::int64_t write(int fd, const void* buffer, std::size_t size) override;
    std::int64_t read_folder(int fd, void* entries, std::size_t size) override;
    int wait_readable(int fd, Duration timeout) override;
    int device_number(int fd, unsigned& major, unsigned& minor) override;
    int map(int fd, std::size_t length, std::int64_t offset, void*& address) override;
    int unmap(void* address, std::size_t length) override;
    int socket(int domain, int type, int protocol) override;
    int bind(int fd, const void* address, std::size_t size) override;
    int connect(int fd, const void* address, std::size_t size) override;
    int set_option(int fd, int level, int name, const void* value, std::size_t size) override;
    std::int64_t receive(int fd, ::msghdr& message) override;
};

}  // namespace facet
