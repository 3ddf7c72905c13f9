// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/sink_mavlink/mavlink_frame.h"

#include <arpa/inet.h>
#include <asm/termbits.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <memory>
#include <vector>

#include "drivers/sink_mavlink/sink_mavlink.h"
#include "platform/linux/linux_kernel_io.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/fake_kernel.h"
#include "tests/support/scripted_source.h"

namespace facet {
namespace {

using Bytes = std::vector<std::uint8_t>;

Odometry example() {
    Odometry o;
    o.stamp.ns = 1'234'567'890;
    o.p_W_B = {1, 2, 3};
    o.q_W_B = Eigen::Quaterniond(0.5, 0.5, 0.5, 0.5);  // x of B lies along y of W, y along z, z along x
    o.v_W_B = {0, 4, 0};
    o.w_B = {0.1, 0.2, 0.3};
    o.pose_covariance.diagonal() << 0.01, 0.02, 0.03, 0.001, 0.002, 0.003;
    o.pose_covariance(0, 1) = o.pose_covariance(1, 0) = 0.005;
    o.pose_covariance(1, 2) = o.pose_covariance(2, 1) = 0.004;
    o.v_covariance = Eigen::Vector3d(0.1, 0.2, 0.3).asDiagonal();
    o.w_covariance = Eigen::Vector3d(0.04, 0.05, 0.06).asDiagonal();
    o.quality = 80;
    o.reset_counter = 5;
    return o;
}

/// Made with Python's struct from the values worked out by hand: position (1, -2, -3), attitude (0.5, 0.5, -0.5, -0.5),
/// velocity (4, 0, 0), rates (0.1, -0.2, -0.3); covariance xy -0.005, yz 0.004; velocity's diagonal 0.2, 0.3, 0.1.
const Bytes kGolden{
    0xFD, 0xE9, 0x00, 0x00, 0x08, 0x01, 0xC5, 0x4B, 0x01, 0x00, 0x87, 0xD6, 0x12, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x80, 0x3F, 0x00, 0x00, 0x00, 0xC0, 0x00, 0x00, 0x40, 0xC0, 0x00, 0x00, 0x00, 0x3F, 0x00, 0x00, 0x00, 0x3F,
    0x00, 0x00, 0x00, 0xBF, 0x00, 0x00, 0x00, 0xBF, 0x00, 0x00, 0x80, 0x40, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0xCD, 0xCC, 0xCC, 0x3D, 0xCD, 0xCC, 0x4C, 0xBE, 0x9A, 0x99, 0x99, 0xBE, 0x0A, 0xD7, 0x23, 0x3C, 0x0A, 0xD7,
    0xA3, 0xBB, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x0A,
    0xD7, 0xA3, 0x3C, 0x6F, 0x12, 0x83, 0x3B, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x8F, 0xC2, 0xF5, 0x3C, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x6F, 0x12, 0x83,
    0x3A, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x6F, 0x12, 0x03, 0x3B, 0x00, 0x00, 0x00, 0x00, 0xA6, 0x9B,
    0x44, 0x3B, 0xCD, 0xCC, 0x4C, 0x3E, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x9A, 0x99, 0x99, 0x3E, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0xCD, 0xCC, 0xCC, 0x3D, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x0A, 0xD7, 0x23, 0x3D, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0xCD, 0xCC,
    0x4C, 0x3D, 0x00, 0x00, 0x00, 0x00, 0x8F, 0xC2, 0x75, 0x3D, 0x14, 0x0C, 0x05, 0x03, 0x50, 0xA6, 0xDB};

TEST_CASE("the checksum gives the catalogue's check value") {
    const Bytes text{'1', '2', '3', '4', '5', '6', '7', '8', '9'};
    CHECK(mavlink_crc(text) == 0x6F91);
}

TEST_CASE("golden bytes of ODOMETRY and HEARTBEAT") {
    MavlinkFrame frame;
    REQUIRE(encode_odometry(example(), {}, 8, frame) == Status::kOk);
    CHECK(Bytes(frame.begin(), frame.end()) == kGolden);
    encode_heartbeat({}, 7, frame);
    CHECK(Bytes(frame.begin(), frame.end()) == Bytes{0xFD, 0x09, 0x00, 0x00, 0x07, 0x01, 0xC5, 0x00, 0x00, 0x00, 0x00,
                                                     0x00, 0x00, 0x00, 0x12, 0x08, 0x00, 0x04, 0x03, 0x5D, 0x56});
}

TEST_CASE("the other sign of the quaternion gives the same bytes; zeros at the end are cut") {
    Odometry o = example();
    o.q_W_B.coeffs() = -o.q_W_B.coeffs();
    MavlinkFrame frame;
    REQUIRE(encode_odometry(o, {}, 8, frame) == Status::kOk);
    CHECK(Bytes(frame.begin(), frame.end()) == kGolden);
    o.quality = 0;
    REQUIRE(encode_odometry(o, {}, 8, frame) == Status::kOk);
    CHECK(frame.size() == kGolden.size() - 1);
    CHECK(frame[1] == 232);
    o.quality = -1;
    REQUIRE(encode_odometry(o, {}, 8, frame) == Status::kOk);
    CHECK(frame[10 + 232] == 0xFF);
}

TEST_CASE("numbers that a flight controller must not get are refused") {
    const auto refused = [](auto change) {
        Odometry o = example();
        change(o);
        MavlinkFrame frame;
        frame.push_back(7);
        const Status status = encode_odometry(o, {}, 0, frame);
        return status == Status::kInvalidArgument && frame.size() == 1;
    };
    const double nan = std::numeric_limits<double>::quiet_NaN();
    CHECK(refused([&](Odometry& o) { o.p_W_B.x() = nan; }));
    CHECK(refused([&](Odometry& o) { o.v_W_B.z() = HUGE_VAL; }));
    CHECK(refused([&](Odometry& o) { o.q_W_B.coeffs() *= 2.0; }));
    CHECK(refused([&](Odometry& o) { o.pose_covariance(2, 2) = 0.0; }));
    CHECK(refused([&](Odometry& o) { o.v_covariance(1, 1) = -1.0; }));
    CHECK(refused([&](Odometry& o) { o.quality = 101; }));
}

/// A kernel with one UDP socket.
class FakeUdp final : public test::FakeKernel {
public:
    std::vector<Bytes> datagrams;
    int result = 0;  ///< a failure for every write
    int opened = 0;
    std::uint16_t port = 0;
    int socket(int domain, int type, int) override {
        ++opened;
        return domain == AF_INET && (type & SOCK_NONBLOCK) != 0 ? 6 : -EINVAL;
    }
    int connect(int, const void* address, std::size_t) override {
        sockaddr_in in{};
        std::memcpy(&in, address, sizeof in);
        port = ntohs(in.sin_port);
        return 0;
    }
    int close(int) override {
        --opened;
        return 0;
    }
    std::int64_t write(int, const void* buffer, std::size_t size) override {
        if (result < 0) {
            return result;
        }
        const auto* bytes = static_cast<const std::uint8_t*>(buffer);
        datagrams.emplace_back(bytes, bytes + size);
        return static_cast<std::int64_t>(size);
    }
};

TEST_CASE("odometry goes out with a heartbeat a second, sequence numbers and without heap") {
    ManualClock clock;
    FakeUdp kernel;
    SinkMavlink sink(kernel, clock, {});
    CHECK(sink.send(example()) == Status::kIo);
    std::string problem;
    REQUIRE(sink.open(problem) == Status::kOk);
    CHECK(kernel.port == 14540);
    kernel.datagrams.reserve(100);
    for (int i = 0; i < 40; ++i) {
        REQUIRE(sink.send(example()) == Status::kOk);
        clock.advance({50'000'000});
    }
    CHECK(kernel.datagrams.size() == 42);
    CHECK(std::count_if(kernel.datagrams.begin(), kernel.datagrams.end(), [](const Bytes& b) { return b[7] == 0; }) ==
          2);
    for (std::size_t i = 1; i < kernel.datagrams.size(); ++i) {
        CHECK(kernel.datagrams[i][4] == static_cast<std::uint8_t>(kernel.datagrams[i - 1][4] + 1));
    }
    kernel.result = -EAGAIN;
    const test::AllocationGuard guard;
    const Status full = sink.send(example());
    const auto allocations = guard.allocations();
    CHECK(full == Status::kFull);
    CHECK(allocations == 0);
    kernel.result = -ECONNREFUSED;
    CHECK(sink.send(example()) == Status::kIo);
    sink.close();
    CHECK(kernel.opened == 0);
}

TEST_CASE("an address that is none is refused in words") {
    ManualClock clock;
    FakeUdp kernel;
    SinkMavlinkOptions options;
    options.udp_host = "autopilot";
    SinkMavlink sink(kernel, clock, options);
    std::string problem;
    CHECK(sink.open(problem) == Status::kInvalidArgument);
    CHECK(problem == "mavlink: 'autopilot:14540' is not an IPv4 address and port");
}

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
    SinkMavlinkOptions options;
    options.serial = autopilot.path();
    options.baud = 500000;
    SinkMavlink sink(io, clock, options);
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
    const Bytes got = autopilot.read();
    // A heartbeat, then the frame of the golden bytes but for sequence, address and checksum.
    REQUIRE(got.size() > kGolden.size());
    const Bytes odometry(got.end() - static_cast<std::ptrdiff_t>(kGolden.size()), got.end());
    CHECK(std::equal(odometry.begin() + 10, odometry.end() - 2, kGolden.begin() + 10));
    ::close(line);
}

TEST_CASE("a serial line that is none, is not there, or vanishes") {
    ManualClock clock;
    LinuxKernelIo io;
    SinkMavlinkOptions options;
    options.serial = "/dev/no_such_line";
    SinkMavlink nothing(io, clock, options);
    std::string problem;
    CHECK(nothing.open(problem) == Status::kNotFound);
    CHECK(problem == "mavlink: /dev/no_such_line: cannot be opened: No such file or directory");
    auto autopilot = std::make_unique<FarEnd>();
    if (!has_any_speed(*autopilot)) {
        return;
    }
    options.serial = "/dev/null";
    SinkMavlink null(io, clock, options);
    CHECK(null.open(problem) == Status::kInvalidArgument);
    CHECK(problem == "mavlink: /dev/null: not a serial line");

    options.serial = autopilot->path();
    SinkMavlink sink(io, clock, options);
    REQUIRE(sink.open(problem) == Status::kOk);
    autopilot.reset();
    CHECK(sink.send(example()) == Status::kIo);
    clock.advance({100'000'000});
    CHECK(sink.send(example()) == Status::kIo);  // too early to open it again
    CHECK(sink.sent() == 0);
    CHECK(sink.dropped() >= 2);
}

}  // namespace
}  // namespace facet
