// SPDX-License-Identifier: BSD-2-Clause
// A kernel without devices: the base of the scripted kernels that driver tests run on.
#pragma once

#include <cerrno>

#include "platform/port/kernel_io.h"

namespace facet::test {

/// Refuses every call with -ENOSYS; a test's kernel overrides what its driver needs.
class FakeKernel : public KernelIo {
public:
    int open(const char*, int) override { return -ENOSYS; }
    int close(int) override { return -ENOSYS; }
    int ioctl(int, unsigned long, void*) override { return -ENOSYS; }
    std::int64_t read(int, void*, std::size_t) override { return -ENOSYS; }
    std::int64_t write(int, const void*, std::size_t) override { return -ENOSYS; }
    std::int64_t read_folder(int, void*, std::size_t) override { return -ENOSYS; }
    int wait_readable(int, Duration) override { return -ENOSYS; }
    int device_number(int, unsigned&, unsigned&) override { return -ENOSYS; }
    int map(int, std::size_t, std::int64_t, void*&) override { return -ENOSYS; }
    int unmap(void*, std::size_t) override { return -ENOSYS; }
    int socket(int, int, int) override { return -ENOSYS; }
    int bind(int, const void*, std::size_t) override { return -ENOSYS; }
    int connect(int, const void*, std::size_t) override { return -ENOSYS; }
    int set_option(int, int, int, const void*, std::size_t) override { return -ENOSYS; }
    std::int64_t receive(int, ::msghdr&) override { return -ENOSYS; }
};

}  // namespace facet::test
