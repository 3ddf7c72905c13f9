// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/service_notifier.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <cstring>

#include "platform/linux/linux_kernel_io.h"
#include "tests/support/scripted_source.h"
#include "tests/support/temp_dir.h"

namespace facet::service_notifier_test {
namespace {

/// The receiving end, as systemd has it.
class Listener {
public:
    explicit Listener(const std::string& name) {
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        std::memcpy(address.sun_path, name.data(), name.size());
        const bool abstract = name[0] == '@';
        if (abstract) {
            address.sun_path[0] = '\0';
        }
        fd_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0);
        const std::size_t size = offsetof(sockaddr_un, sun_path) + name.size() + (abstract ? 0 : 1);
        REQUIRE(::bind(fd_, reinterpret_cast<const sockaddr*>(&address), static_cast<socklen_t>(size)) == 0);
    }
    ~Listener() { ::close(fd_); }
    Listener(const Listener&) = delete;
    Listener& operator=(const Listener&) = delete;

    /// Next datagram; empty if there is none.
    std::string next() {
        std::array<char, 256> buffer{};
        const auto size = ::recv(fd_, buffer.data(), buffer.size(), 0);
        return size > 0 ? std::string(buffer.data(), static_cast<std::size_t>(size)) : "";
    }

private:
    int fd_ = -1;
};

TEST_CASE("systemd is notified of start, state and stop over a path or an abstract name") {
    const test::TempDir dir;
    const std::string name = GENERATE(true, false) ? dir.file("notify") : "@facet-test-" + std::to_string(::getpid());
    Listener listener(name);
    LinuxKernelIo io;
    ManualClock clock;
    ServiceNotifier notifier(io, clock, name, "", "", ::getpid());
    notifier.ready();
    notifier.status("TRACKING");
    notifier.feed();  // nobody asked for a watchdog
    notifier.stopping();
    CHECK(listener.next() == "READY=1");
    CHECK(listener.next() == "STATUS=TRACKING");
    CHECK(listener.next() == "STOPPING=1");
    CHECK(listener.next().empty());
}

TEST_CASE("the watchdog is fed when it is to be, and not too often") {
    const test::TempDir dir;
    Listener listener(dir.file("notify"));
    LinuxKernelIo io;
    ManualClock clock;
    ServiceNotifier notifier(io, clock, dir.file("notify"), "4000000", std::to_string(::getpid()), ::getpid());
    CHECK(notifier.is_watched());
    CHECK(listener.next().empty());
    notifier.feed();
    CHECK(listener.next() == "WATCHDOG=1");
    notifier.feed();
    CHECK(listener.next().empty());  // a quarter of the period has not passed
    clock.advance(Duration::from_seconds(1.0));
    notifier.feed();
    CHECK(listener.next() == "WATCHDOG=1");
}

TEST_CASE("another process's watchdog, no socket and a dead one are no business of ours") {
    const test::TempDir dir;
    Listener listener(dir.file("notify"));
    LinuxKernelIo io;
    ManualClock clock;
    ServiceNotifier other(io, clock, dir.file("notify"), "1000000", "1", ::getpid());
    CHECK_FALSE(other.is_watched());
    other.feed();
    CHECK(listener.next().empty());
    ServiceNotifier garbage(io, clock, dir.file("notify"), "soon", "", ::getpid());
    CHECK_FALSE(garbage.is_watched());
    garbage.feed();
    CHECK(listener.next().empty());
    for (const std::string& socket : {std::string(), dir.file("none"), std::string(300, 'x')}) {
        ServiceNotifier nobody(io, clock, socket, "1000000", "", ::getpid());
        nobody.ready();
        nobody.feed();
    }
}

}  // namespace
}  // namespace facet::service_notifier_test
