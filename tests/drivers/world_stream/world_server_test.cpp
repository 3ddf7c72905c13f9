// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/world_stream/world_server.h"

#include <grp.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <fstream>
#include <span>
#include <string>
#include <thread>

#include "drivers/world_stream/world_reader.h"
#include "tests/drivers/world_stream/changing_world.h"
#include "tests/support/allocation_guard.h"

namespace facet::world_server_test {
namespace {

using test::ChangingWorld;

std::string socket_path() { return "/tmp/facet_world_" + std::to_string(::getpid()); }

sockaddr_un address_of(const std::string& path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::copy(path.begin(), path.end(), std::begin(address.sun_path));
    return address;
}

/// @return the socket; negative if nobody listens
int connect_to(const std::string& path) {
    const sockaddr_un address = address_of(path);
    const int socket = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
        ::close(socket);
        return -1;
    }
    return socket;
}

void publish(WorldServer& server, const WorldState& state) {
    server.next() = state;
    server.publish();
}

/// Waits until the reader has this keyframe, for some seconds at most.
bool reaches(WorldReader& reader, std::uint64_t sequence) {
    for (int i = 0; i < 50 && reader.state().sequence < sequence; ++i) {
        const Status status = reader.wait(100);
        if (!ok(status) && status != Status::kNotReady) {
            return false;
        }
    }
    return reader.state().sequence == sequence;
}

TEST_CASE("readers of a server have its state at every keyframe, also those that join late") {
    WorldServer server;
    REQUIRE(ok(server.open(socket_path())));
    ChangingWorld world;
    WorldReader early;
    WorldReader late;
    REQUIRE(ok(early.open(socket_path())));
    for (std::uint64_t k = 1; k <= 30; ++k) {
        publish(server, world.advance());
        REQUIRE(reaches(early, k));
        REQUIRE(early.state() == world.state());
        if (k == 15) {
            REQUIRE(ok(late.open(socket_path())));
        }
        if (k >= 15) {
            REQUIRE(reaches(late, k));
            REQUIRE(late.state() == world.state());
        }
    }
    CHECK(early.missed() == 0);
    CHECK(late.missed() == 0);
    CHECK(server.dropped() == 0);
}

TEST_CASE("a reader that does not read costs the publisher nothing, and catches up with a snapshot") {
    WorldServer server;
    REQUIRE(ok(server.open(socket_path())));
    ChangingWorld world;
    WorldReader reader;
    REQUIRE(ok(reader.open(socket_path())));
    publish(server, world.advance());
    REQUIRE(reaches(reader, 1));
    constexpr std::uint64_t kKeyframes = 400;
    for (std::uint64_t k = 2; k <= kKeyframes; ++k) {
        server.next() = world.advance();
        const test::AllocationGuard guard;
        server.publish();
        const std::uint64_t allocations = guard.allocations();
        REQUIRE(allocations == 0);
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    CHECK(server.dropped() > 0);
    REQUIRE(reaches(reader, kKeyframes));
    CHECK(reader.state() == world.state());
    CHECK(reader.missed() > 0);
}

TEST_CASE("the last state arrives when the server closes; the socket is gone") {
    ChangingWorld world;
    WorldReader reader;
    {
        WorldServer server;
        REQUIRE(ok(server.open(socket_path())));
        REQUIRE(ok(reader.open(socket_path())));
        publish(server, world.advance());
        REQUIRE(reaches(reader, 1));
        publish(server, world.advance());
    }
    CHECK(reaches(reader, 2));
    CHECK(reader.state() == world.state());
    CHECK(reader.wait(100) == Status::kEndOfStream);
    CHECK(reader.open(socket_path()) == Status::kIo);
}

double processor_time_s() {
    rusage used{};
    REQUIRE(::getrusage(RUSAGE_SELF, &used) == 0);
    return static_cast<double>(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
           1e-6 * static_cast<double>(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
}

/// What a socket is sent, up to a keyframe.
WorldState read_up_to(int socket, std::uint64_t sequence) {
    WorldDecoder decoder;
    std::array<std::uint8_t, 65536> bytes{};
    for (ssize_t got = 1; got > 0 && decoder.state().sequence < sequence;) {
        got = ::recv(socket, bytes.data(), bytes.size(), 0);
        if (got > 0 && decoder.add(std::span(bytes).first(static_cast<std::size_t>(got))) == Status::kCorrupt) {
            break;
        }
    }
    CHECK(decoder.out_of_order() == 0);
    return decoder.state();
}

TEST_CASE("without descriptors for more readers the server serves those it has, and does not keep a core busy") {
    WorldServer server;
    ChangingWorld world;
    WorldReader reader;
    REQUIRE(ok(server.open(socket_path())));
    REQUIRE(ok(reader.open(socket_path())));
    publish(server, world.advance());
    REQUIRE(reaches(reader, 1));
    const int late = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const int next = ::dup(0);  // the lowest that is free
    ::close(next);
    rlimit before{};
    REQUIRE(::getrlimit(RLIMIT_NOFILE, &before) == 0);
    const rlimit none_left{static_cast<rlim_t>(next), before.rlim_max};
    const std::string path = socket_path();
    const sockaddr_un address = address_of(path);
    REQUIRE(::setrlimit(RLIMIT_NOFILE, &none_left) == 0);
    // The kernel takes the connection, and the server cannot.
    const int connected = ::connect(late, reinterpret_cast<const sockaddr*>(&address), sizeof(address));
    const double begin_s = processor_time_s();
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    const double used_s = processor_time_s() - begin_s;
    publish(server, world.advance());
    const bool is_served = reaches(reader, 2);
    REQUIRE(::setrlimit(RLIMIT_NOFILE, &before) == 0);
    CHECK(connected == 0);
    CHECK(used_s < 0.2);
    CHECK(is_served);
    CHECK(read_up_to(late, 2) == world.state());
    ::close(late);
}

TEST_CASE("a server that opens again sends nothing of what a slow reader had left") {
    WorldServer server;
    ChangingWorld world;
    WorldReader slow;
    REQUIRE(ok(server.open(socket_path())));
    REQUIRE(ok(slow.open(socket_path())));
    for (int k = 0; k < 1000 && server.dropped() == 0; ++k) {
        publish(server, world.advance());
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    REQUIRE(server.dropped() > 0);
    server.close();

    REQUIRE(ok(server.open(socket_path())));
    const int reader = connect_to(socket_path());
    REQUIRE(reader >= 0);
    publish(server, ChangingWorld().advance());
    CHECK(read_up_to(reader, 1) == ChangingWorld().advance());
    ::close(reader);
}

TEST_CASE("the socket has the group and the mode that it is to have, whatever the umask") {
    const ::group* const own = ::getgrgid(::getgid());
    REQUIRE(own != nullptr);
    const std::string name = own->gr_name;
    const mode_t before = ::umask(0077);
    for (const unsigned mode : {0660U, 0600U, 0666U}) {
        WorldServer server;
        REQUIRE(ok(server.open(socket_path(), {name, mode})));
        struct stat info {};
        REQUIRE(::stat(socket_path().c_str(), &info) == 0);
        CHECK((info.st_mode & 0777U) == mode);
        CHECK(info.st_gid == ::getgid());
    }
    ::umask(before);
    WorldServer server;
    CHECK(server.open(socket_path(), {"no-such-group", 0660U}) == Status::kNotFound);
    CHECK(connect_to(socket_path()) < 0);
}

TEST_CASE("a path is served once; what a dead program left is replaced, a file is not") {
    WorldServer first;
    REQUIRE(ok(first.open(socket_path())));
    WorldServer second;
    CHECK(second.open(socket_path()) == Status::kFull);
    first.close();
    const int dead = ::socket(AF_UNIX, SOCK_STREAM, 0);
    const std::string path = socket_path();
    const sockaddr_un address = address_of(path);
    REQUIRE(::bind(dead, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0);
    ::close(dead);
    CHECK(ok(second.open(path)));
    second.close();
    CHECK(second.open(std::string(200, 'x')) == Status::kInvalidArgument);
    CHECK(second.open("/tmp") == Status::kFull);
    const std::string file = socket_path() + "_file";
    std::ofstream(file) << "not ours";
    CHECK(second.open(file) == Status::kFull);
    CHECK(::unlink(file.c_str()) == 0);
    CHECK(second.open("/nonexistent/socket") == Status::kIo);
}

}  // namespace
}  // namespace facet::world_server_test
