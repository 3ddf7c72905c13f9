// SPDX-License-Identifier: BSD-2-Clause
#include "platform/linux/linux_kernel_io.h"

#include <fcntl.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <cerrno>
#include <string>

#include "tests/support/temp_dir.h"

namespace facet::linux_kernel_io_test {
namespace {

TEST_CASE("failures come back as negative errno values") {
    LinuxKernelIo io;
    CHECK(io.open("/nonexistent/device", O_RDWR) == -ENOENT);
    CHECK(io.close(-1) == -EBADF);
    CHECK(io.ioctl(-1, FIONREAD, nullptr) == -EBADF);
    std::array<char, 4> buffer{};
    CHECK(io.read(-1, buffer.data(), buffer.size()) == -EBADF);
    CHECK(io.write(-1, buffer.data(), buffer.size()) == -EBADF);
    void* address = nullptr;
    CHECK(io.map(-1, 4096, 0, address) == -EBADF);
    CHECK(address == nullptr);
    CHECK(io.socket(AF_INET, -1, 0) < 0);
    const sockaddr address_of_none{};
    CHECK(io.bind(-1, &address_of_none, sizeof(address_of_none)) == -EBADF);
    CHECK(io.set_option(-1, SOL_SOCKET, SO_RCVBUF, buffer.data(), 4) == -EBADF);
}

TEST_CASE("a device has its numbers by whatever name it is opened") {
    const test::TempDir dir;
    LinuxKernelIo io;
    const std::string alias = dir.file("alias");
    REQUIRE(::symlink("/dev/null", alias.c_str()) == 0);
    const int fd = io.open(alias.c_str(), O_RDONLY);
    REQUIRE(fd >= 0);
    unsigned major = 0;
    unsigned minor = 0;
    CHECK(io.device_number(fd, major, minor) == 0);
    CHECK(major == 1);
    CHECK(minor == 3);
    CHECK(io.close(fd) == 0);
    CHECK(io.device_number(-1, major, minor) == -EBADF);
}

TEST_CASE("a file is written, mapped and read through the interface") {
    const test::TempDir dir;
    LinuxKernelIo io;
    const int fd = io.open(dir.write("a", "hello world").c_str(), O_RDWR);
    REQUIRE(fd >= 0);
    CHECK((fcntl(fd, F_GETFD) & FD_CLOEXEC) != 0);
    std::array<char, 5> buffer{};
    CHECK(io.read(fd, buffer.data(), buffer.size()) == 5);
    CHECK(std::string(buffer.data(), 5) == "hello");
    void* address = nullptr;
    REQUIRE(io.map(fd, 11, 0, address) == 0);
    static_cast<char*>(address)[0] = 'H';
    CHECK(io.unmap(address, 11) == 0);
    CHECK(io.close(fd) == 0);
    CHECK(test::read_file(dir.file("a")) == "Hello world");
}

TEST_CASE("waiting for a pipe ends when there is something to read") {
    LinuxKernelIo io;
    std::array<int, 2> ends{};
    REQUIRE(pipe(ends.data()) == 0);
    CHECK(io.wait_readable(ends[0], Duration{}) == 0);
    CHECK(io.wait_readable(ends[0], Duration::from_seconds(0.002)) == 0);
    CHECK(io.write(ends[1], "x", 1) == 1);
    CHECK(io.wait_readable(ends[0], Duration::from_seconds(10.0)) == 1);
    (void)io.close(ends[1]);
    (void)io.close(ends[0]);
}

}  // namespace
}  // namespace facet::linux_kernel_io_test
