// SPDX-License-Identifier: BSD-2-Clause
// MavlinkLink on serial lines of the kernel.
#include <asm/termbits.h>
#include <fcntl.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "drivers/mavlink/mavlink_link.h"
#include "platform/linux/linux_kernel_io.h"
#include "tests/drivers/mavlink/link_scene.h"

namespace facet::mavlink_serial_test {
namespace {

using test::Bytes;
using test::example;

/// The far end of a serial line: a pseudo-terminal of the kernel.
class FarEnd {
public:
    FarEnd() : fd_(::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK)) {
        REQUIRE(::grantpt(fd_) == 0);
        REQUIRE(::unlockpt(fd_) == 0);
        path_ = ::ptsname(fd_);
    }
    ~FarEnd() { ::close(fd_); }
    FarEnd(const FarEnd&) = delete;
    FarEnd& operator=(const FarEnd&) = delete;
    const std::string& path() const { return path_; }
    void write(const Bytes& bytes) const {
        REQUIRE(::write(fd_, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()));
    }
    Bytes read() const {
        Bytes bytes(4096);
        const auto size = ::read(fd_, bytes.data(), bytes.size());
        bytes.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
        return bytes;
    }

private:
    int fd_;
    std::string path_;
};

/// Emulators of another processor may lack the system call that sets any speed.
bool has_any_speed(const FarEnd& line) {
    const int fd = ::open(line.path().c_str(), O_RDWR | O_NOCTTY);
    termios2 settings{};
    const bool lacks = ::ioctl(fd, TCGETS2, &settings) != 0 && errno == ENOSYS;
    ::close(fd);
    if (lacks) {
        WARN("skipped: no serial line of any speed here");
    }
    return !lacks;
}

TEST_CASE("over a serial line every byte arrives as it was sent") {
    const FarEnd autopilot;
    if (!has_any_speed(autopilot)) {
        return;
    }
    ManualClock clock;
    LinuxKernelIo io;
    MavlinkOptions options;
    options.channel.serial = autopilot.path();
    options.channel.baud = 500000;
    MavlinkLink sink(io, clock, options);
    std::string problem;
    INFO(problem);
    REQUIRE(sink.open(problem) == Status::kOk);
    CHECK(sink.name() == autopilot.path());
    const int line = ::open(autopilot.path().c_str(), O_RDWR | O_NOCTTY);
    termios2 settings{};
    REQUIRE(::ioctl(line, TCGETS2, &settings) == 0);
    CHECK(settings.c_ospeed == 500000);
    CHECK((settings.c_oflag & OPOST) == 0);
    CHECK((settings.c_lflag & (ICANON | ECHO)) == 0);
    REQUIRE(sink.send(example()) == Status::kOk);
    MavlinkParser parser;
    MavlinkPacket packet;
    std::span<const std::uint8_t> raw;
    std::vector<MavlinkId> ids;
    for (int i = 0; i < 1'000 && ids.size() < 3; ++i) {  // the kernel passes bytes on in its own time
        (void)parser.feed(autopilot.read());
        while (ok(parser.next(packet, raw))) {
            ids.push_back(packet.id);
        }
        ::usleep(1'000);
    }
    CHECK(ids == std::vector{MavlinkId::kHeartbeat, MavlinkId::kTimesync, MavlinkId::kOdometry});
    CHECK(parser.counters().skipped == 0);
    autopilot.write({0x11, 0x13, 0xFD});  // what a line discipline would swallow, and half a frame
    MavlinkPayload payload;
    encode(MavHeartbeat{.type = 2, .autopilot = 12, .base_mode = 0x80}, payload);
    MavlinkFrame frame;
    pack_mavlink(MavlinkId::kHeartbeat, {payload.data(), payload.size()}, {1, 1}, 0, frame);
    for (int i = 0; i < 20; ++i) {  // enough for the half frame to be found out
        autopilot.write({frame.begin(), frame.end()});
    }
    for (int i = 0; i < 1'000 && sink.arming() != Arming::kArmed; ++i) {
        sink.service();
        ::usleep(1'000);
    }
    CHECK(sink.arming() == Arming::kArmed);
    ::close(line);
}

TEST_CASE("a serial line that is not one, is missing, or vanishes") {
    ManualClock clock;
    LinuxKernelIo io;
    MavlinkOptions options;
    options.channel.serial = "/dev/no_such_line";
    MavlinkLink nothing(io, clock, options);
    std::string problem;
    CHECK(nothing.open(problem) == Status::kNotFound);
    CHECK(problem == "mavlink: /dev/no_such_line: cannot be opened: No such file or directory");
    auto autopilot = std::make_unique<FarEnd>();
    if (!has_any_speed(*autopilot)) {
        return;
    }
    options.channel.serial = "/dev/null";
    MavlinkLink null(io, clock, options);
    CHECK(null.open(problem) == Status::kInvalidArgument);
    CHECK(problem == "mavlink: /dev/null: not a serial line");

    options.channel.serial = autopilot->path();
    MavlinkLink sink(io, clock, options);
    REQUIRE(sink.open(problem) == Status::kOk);
    autopilot.reset();
    CHECK(sink.send(example()) == Status::kIo);
    clock.advance({100'000'000});
    CHECK(sink.send(example()) == Status::kIo);  // too early to open it again
    CHECK(sink.counters().sent == 0);
    CHECK(sink.counters().dropped >= 2);
}

}  // namespace
}  // namespace facet::mavlink_serial_test
