// SPDX-License-Identifier: BSD-2-Clause
#include "platform/linux/linux_kernel_io.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <cerrno>
#include <ctime>

namespace facet {
namespace {

/// The result of `call`, repeated while a signal interrupts it; -errno on failure.
template <class Call>
auto checked(Call call) -> decltype(call()) {
    for (;;) {
        const auto result = call();
        if (result >= 0) {
            return result;
        }
        if (errno != EINTR) {
            return static_cast<decltype(call())>(-errno);
        }
    }
}

}  // namespace

int LinuxKernelIo::open(const char* path, int flags) {
    return checked([&] { return ::open(path, flags | O_CLOEXEC); });
}

// Not repeated: after EINTR the descriptor is closed already.
int LinuxKernelIo::close(int fd) { return ::close(fd) == 0 || errno == EINTR ? 0 : -errno; }

int LinuxKernelIo::ioctl(int fd, unsigned long request, void* argument) {
    return checked([&] { return ::ioctl(fd, request, argument); });
}

std::int64_t LinuxKernelIo::read(int fd, void* buffer, std::size_t size) {
    return checked([&]() -> std::int64_t { return ::read(fd, buffer, size); });
}

std::int64_t LinuxKernelIo::write(int fd, const void* buffer, std::size_t size) {
    return checked([&]() -> std::int64_t { return ::write(fd, buffer, size); });
}

// By its number: the C library of older systems has no such function.
std::int64_t LinuxKernelIo::read_folder(int fd, void* entries, std::size_t size) {
    return checked([&]() -> std::int64_t { return ::syscall(SYS_getdents64, fd, entries, size); });
}

int LinuxKernelIo::device_number(int fd, unsigned& major, unsigned& minor) {
    struct stat info {};
    if (::fstat(fd, &info) != 0) {
        return -errno;
    }
    major = gnu_dev_major(info.st_rdev);
    minor = gnu_dev_minor(info.st_rdev);
    return 0;
}

int LinuxKernelIo::wait_readable(int fd, Duration timeout) {
    pollfd request{fd, POLLIN | POLLPRI, 0};
    timespec limit{};
    if (timeout.ns > 0) {
        limit.tv_sec = static_cast<std::time_t>(timeout.ns / 1'000'000'000);
        limit.tv_nsec = static_cast<long>(timeout.ns % 1'000'000'000);
    }
    const int ready = ::ppoll(&request, 1, &limit, nullptr);
    // A signal counts as a timeout: the caller looks whether it is to stop.
    return ready >= 0 ? ready : (errno == EINTR ? 0 : -errno);
}

int LinuxKernelIo::map(int fd, std::size_t length, std::int64_t offset, void*& address) {
    void* const mapped = ::mmap(nullptr, length, PROT_READ | PROT_WRITE, MAP_SHARED, fd, offset);
    if (mapped == MAP_FAILED) {
        return -errno;
    }
    address = mapped;
    return 0;
}

int LinuxKernelIo::unmap(void* address, std::size_t length) { return ::munmap(address, length) == 0 ? 0 : -errno; }

int LinuxKernelIo::socket(int domain, int type, int protocol) {
    return checked([&] { return ::socket(domain, type | SOCK_CLOEXEC, protocol); });
}

int LinuxKernelIo::bind(int fd, const void* address, std::size_t size) {
    return checked([&] { return ::bind(fd, static_cast<const sockaddr*>(address), static_cast<socklen_t>(size)); });
}

int LinuxKernelIo::connect(int fd, const void* address, std::size_t size) {
    return checked([&] { return ::connect(fd, static_cast<const sockaddr*>(address), static_cast<socklen_t>(size)); });
}

int LinuxKernelIo::set_option(int fd, int level, int name, const void* value, std::size_t size) {
    return checked([&] { return ::setsockopt(fd, level, name, value, static_cast<socklen_t>(size)); });
}

std::int64_t LinuxKernelIo::receive(int fd, ::msghdr& message) {
    return checked([&]() -> std::int64_t { return ::recvmsg(fd, &message, 0); });
}

}  // namespace facet
