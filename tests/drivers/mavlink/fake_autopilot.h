// SPDX-License-Identifier: BSD-2-Clause
// A flight controller with a clock of its own, behind a link with delays: a scripted kernel for tests of ImuMavlink.
#pragma once

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <random>
#include <span>
#include <vector>

#include "drivers/mavlink/imu_mavlink.h"
#include "drivers/mavlink/mavlink_parser.h"
#include "tests/support/fake_kernel.h"
#include "tests/support/scripted_source.h"

namespace facet::test {

/// What the controller does; changed while it runs.
struct Autopilot {
    double boot_s = -3600.0;  ///< our time when its clock began
    double drift = 0.0;       ///< its clock's
    Duration up{200'000};     ///< delays of the link
    Duration down{300'000};
    Duration jitter;  ///< uniform, added to the latter two
    bool answers_time = true;
    MavResult answer = MavResult::kAccepted;  ///< to SET_MESSAGE_INTERVAL
    bool silent = false;

    std::int64_t time_ns(Timestamp own) const { return std::llround((own.seconds() - boot_s) * (1.0 + drift) * 1e9); }
};

/// HIGHRES_IMU with these values in the message's own axes.
inline MavlinkPayload highres(std::uint64_t time_us, const Eigen::Vector3d& accel, const Eigen::Vector3d& gyro,
                              std::uint16_t fields = 0x3F, std::uint8_t id = 0) {
    MavlinkPayload payload;
    MavlinkWriter out(payload);
    out.put(time_us);
    out.put_vector(accel);
    out.put_vector(gyro);
    for (int i = 0; i < 7; ++i) {
        out.put_float(40.0 + i);
    }
    out.put(fields);
    out.put(id);
    return payload;
}

/// A datagram socket, or a serial line if `is_serial`, with the controller at its other end.
class AutopilotKernel final : public FakeKernel {
public:
    explicit AutopilotKernel(ManualClock& clock) : clock_(clock) {}

    Autopilot autopilot;
    bool port_works = true;
    int opened = 0;
    std::vector<MavCommand> commands;  ///< that were received
    int poses = 0;                     ///< ODOMETRY that was received
    Duration sends_every;              ///< HIGHRES_IMU of a vehicle at rest, while somebody waits; zero: not
    bool is_deaf = false;              ///< what is written is not looked at: no heap

    int socket(int, int, int) override { return open_port(); }
    int bind(int, const void*, std::size_t) override { return 0; }
    int connect(int, const void*, std::size_t) override { return 0; }
    int open(const char*, int) override { return open_port(); }
    int ioctl(int, unsigned long, void*) override { return 0; }
    int close(int) override { return 0; }
    std::int64_t write(int, const void* buffer, std::size_t size) override {
        if (!port_works) {
            return -EIO;
        }
        const auto* bytes = static_cast<const std::uint8_t*>(buffer);
        if (!is_deaf) {
            hear({bytes, size});
        }
        return static_cast<std::int64_t>(size);
    }
    std::int64_t read(int, void* buffer, std::size_t size) override {
        if (!port_works) {
            return -EIO;
        }
        if (arriving_.empty() || arriving_.begin()->first > clock_.now()) {
            return -EAGAIN;
        }
        const std::vector<std::uint8_t>& bytes = arriving_.begin()->second;
        const std::size_t taken = std::min(size, bytes.size());
        std::memcpy(buffer, bytes.data(), taken);
        arriving_.erase(arriving_.begin());
        return static_cast<std::int64_t>(taken);
    }
    int wait_readable(int, Duration timeout) override {
        Timestamp until = clock_.now() + timeout;
        if (!arriving_.empty()) {
            until = std::min(until, std::max(arriving_.begin()->first, clock_.now()));
        }
        if (sends_every.ns > 0) {
            until = std::min(until, std::max(next_reading_, clock_.now()));
        }
        clock_.sleep_until(until);
        if (sends_every.ns > 0 && clock_.now() >= next_reading_) {
            const auto now_us = static_cast<std::uint64_t>(autopilot.time_ns(clock_.now()) / 1000);
            say(highres(now_us, {0, 0, -9.8}, {0, 0, 0}), MavlinkImuMessage::kHighresImu);
            next_reading_ = std::max(next_reading_ + sends_every, clock_.now());
        }
        return 1;
    }

    /// A reading of this instant, or another; on its way from now on. @param late  how much later than others it comes
    void say(const MavlinkPayload& payload, MavlinkImuMessage message, Duration late = {}) {
        if (!autopilot.silent) {
            send(id_of(message), payload, late);
        }
    }

private:
    int open_port() {
        ++opened;
        return port_works ? 6 : -EIO;
    }
    Duration delay(Duration least) {
        std::uniform_int_distribution<std::int64_t> more(0, autopilot.jitter.ns);
        return least + Duration{more(random_)};
    }
    void send(MavlinkId id, const MavlinkPayload& payload, Duration late) {
        MavlinkFrame frame;
        pack_mavlink(id, {payload.data(), payload.size()}, {1, 1}, sequence_++, frame);
        Timestamp due = clock_.now() + late + delay(autopilot.down);
        arriving_.emplace(due, std::vector<std::uint8_t>(frame.begin(), frame.end()));
    }
    void hear(std::span<const std::uint8_t> bytes) {
        MavlinkParser parser;
        MavlinkPacket packet;
        std::span<const std::uint8_t> raw;
        (void)parser.feed(bytes);
        if (!ok(parser.next(packet, raw))) {
            return;
        }
        MavlinkPayload payload;
        if (packet.id == MavlinkId::kCommandLong) {
            commands.push_back(decode_command(packet));
            encode(MavCommandAck{commands.back().command, autopilot.answer, packet.from}, payload);
            send(MavlinkId::kCommandAck, payload, {});
        } else if (packet.id == MavlinkId::kTimesync && autopilot.answers_time) {
            const Duration up = delay(autopilot.up);
            const MavTimesync question = decode_timesync(packet.payload);
            encode(MavTimesync{autopilot.time_ns(clock_.now() + up), question.ts1_ns, packet.from}, payload);
            send(MavlinkId::kTimesync, payload, up);
        }
        poses += packet.id == MavlinkId::kOdometry ? 1 : 0;
    }

    ManualClock& clock_;
    std::multimap<Timestamp, std::vector<std::uint8_t>> arriving_;
    std::mt19937 random_{7};
    std::uint8_t sequence_ = 0;
    Timestamp next_reading_;
};

/// An inertial source on such a kernel, and what a flight at rest looks like.
struct AutopilotScene {
    explicit AutopilotScene(ImuMavlinkOptions chosen = {}, MavlinkOptions link_options = {})
        : options(chosen), link(kernel, clock, std::move(link_options)), imu(link, clock, options) {}

    /// Lets the link find the controller's time.
    void learn_time() {
        for (int i = 0; i < 400 && !link.timesync().ready(); ++i) {
            ImuSample none;
            (void)imu.next(Duration::from_seconds(0.01), none);
        }
    }
    std::uint64_t now_us() const { return static_cast<std::uint64_t>(kernel.autopilot.time_ns(clock.now()) / 1000); }
    /// Sends a reading of now, and lets a period pass. @param late  how much later than others it comes
    void tick(Duration period, Duration late = {}) {
        kernel.say(highres(now_us(), {0.1, 0.2, -9.8}, {0.01, 0.02, 0.03}), options.message, late);
        clock.advance(period);
    }
    /// All that can be had without waiting.
    std::vector<ImuSample> drain() {
        std::vector<ImuSample> samples;
        ImuSample sample;
        for (Status status = Status::kOk; ok(status) || status == Status::kCorrupt;) {
            status = imu.next({}, sample);
            if (ok(status)) {
                samples.push_back(sample);
            }
        }
        return samples;
    }

    ManualClock clock{{100'000'000'000}};
    AutopilotKernel kernel{clock};
    ImuMavlinkOptions options;
    MavlinkLink link;
    ImuMavlink imu;
};

}  // namespace facet::test
