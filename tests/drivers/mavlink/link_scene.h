// SPDX-License-Identifier: BSD-2-Clause
// A MAVLink link on a scripted kernel, and what the other side says and hears.
#pragma once

#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cerrno>
#include <cstring>
#include <deque>
#include <string>
#include <utility>
#include <vector>

#include "drivers/mavlink/mavlink_link.h"
#include "tests/support/fake_kernel.h"
#include "tests/support/scripted_source.h"

namespace facet::test {

using Bytes = std::vector<std::uint8_t>;

inline Odometry example() {
    Odometry o;
    o.stamp.ns = 1'234'567'890;
    o.p_W_B = {1, 2, 3};
    o.quality = 80;
    o.reset_counter = 5;
    return o;
}

/// A kernel with one UDP socket.
class FakeUdp final : public FakeKernel {
public:
    std::vector<Bytes> sent;
    std::deque<Bytes> arriving;
    int result = 0;  ///< a failure for every write
    int opened = 0;
    int refusal = 0;  ///< of every socket
    std::uint16_t port = 0;
    std::uint16_t local_port = 0;

    int socket(int domain, int type, int) override {
        ++opened;
        if (refusal < 0) {
            return refusal;
        }
        return domain == AF_INET && (type & SOCK_NONBLOCK) != 0 ? 6 : -EINVAL;
    }
    int bind(int, const void* address, std::size_t) override {
        local_port = port_of(address);
        return 0;
    }
    int connect(int, const void* address, std::size_t) override {
        port = port_of(address);
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
        sent.emplace_back(bytes, bytes + size);
        return static_cast<std::int64_t>(size);
    }
    std::int64_t read(int, void* buffer, std::size_t size) override {
        if (arriving.empty()) {
            return -EAGAIN;
        }
        const Bytes bytes = arriving.front();
        arriving.pop_front();
        const std::size_t taken = std::min(size, bytes.size());
        std::memcpy(buffer, bytes.data(), taken);
        return static_cast<std::int64_t>(taken);
    }

private:
    static std::uint16_t port_of(const void* address) {
        sockaddr_in in{};
        std::memcpy(&in, address, sizeof in);
        return ntohs(in.sin_port);
    }
};

/// A link, and what the other side says and hears.
struct Scene {
    explicit Scene(MavlinkOptions chosen = {}) : options(std::move(chosen)), link(kernel, clock, options) {
        std::string problem;
        REQUIRE(link.open(problem) == Status::kOk);
    }

    void say(MavlinkId id, const MavlinkPayload& payload, MavlinkAddress from = {1, 1}) {
        MavlinkFrame frame;
        pack_mavlink(id, {payload.data(), payload.size()}, from, sequence++, frame);
        kernel.arriving.emplace_back(frame.begin(), frame.end());
    }
    void say(const MavHeartbeat& heartbeat, MavlinkAddress from = {1, 1}) {
        MavlinkPayload payload;
        encode(heartbeat, payload);
        say(MavlinkId::kHeartbeat, payload, from);
    }
    void say(const MavTimesync& timesync, MavlinkAddress from = {1, 1}) {
        MavlinkPayload payload;
        encode(timesync, payload);
        say(MavlinkId::kTimesync, payload, from);
    }
    void say(const MavCommand& command, MavlinkAddress from, MavlinkId id = MavlinkId::kCommandLong) {
        MavlinkPayload payload;
        MavlinkWriter out(payload);
        for (const float param : command.param) {
            out.put_float(static_cast<double>(param));
        }
        out.put(command.command);
        out.put(command.target.system);
        out.put(command.target.component);
        say(id, payload, from);
    }
    /// Everything of one kind that was sent since the last call for any kind.
    std::vector<MavlinkPacket> heard(MavlinkId id) {
        std::vector<MavlinkPacket> packets;
        for (const Bytes& datagram : kernel.sent) {
            MavlinkParser parser;
            MavlinkPacket packet;
            std::span<const std::uint8_t> raw;
            (void)parser.feed(datagram);
            REQUIRE(parser.next(packet, raw) == Status::kOk);
            REQUIRE(raw.size() == datagram.size());
            if (packet.id == id) {
                packets.push_back(packet);
            }
        }
        kernel.sent.clear();
        return packets;
    }
    void arm(bool armed) {
        say(MavHeartbeat{.type = 2, .autopilot = 12, .base_mode = static_cast<std::uint8_t>(armed ? 0x81 : 0x01)});
        link.service();
    }
    /// Result of a command from a system, or -1 if it is not answered.
    int command(const MavCommand& c, MavlinkAddress from = {255, 190}, MavlinkId id = MavlinkId::kCommandLong) {
        kernel.sent.clear();
        say(c, from, id);
        link.service();
        const auto acks = heard(MavlinkId::kCommandAck);
        if (acks.empty()) {
            return -1;
        }
        MavlinkReader in({acks.back().payload.data(), acks.back().payload.size()});
        CHECK(in.take<std::uint16_t>() == c.command);
        const int result = in.take<std::uint8_t>();
        (void)in.take<std::uint8_t>();
        (void)in.take<std::uint32_t>();
        CHECK(in.take<std::uint8_t>() == from.system);
        CHECK(in.take<std::uint8_t>() == from.component);
        return result;
    }
    MavlinkPacket pose(const Odometry& odometry) {
        kernel.sent.clear();
        REQUIRE(link.send(odometry) == Status::kOk);
        const auto poses = heard(MavlinkId::kOdometry);
        REQUIRE(poses.size() == 1);
        return poses[0];
    }

    ManualClock clock{{100'000'000'000}};
    FakeUdp kernel;
    MavlinkOptions options;
    MavlinkLink link;
    std::uint8_t sequence = 0;
};

}  // namespace facet::test
