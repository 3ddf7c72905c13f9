// SPDX-License-Identifier: BSD-2-Clause
// The link to a flight controller: estimates out; time, arming and commands in.
#pragma once

#include <array>
#include <atomic>
#include <optional>
#include <string>

#include "drivers/common/retry_gate.h"
#include "drivers/mavlink/frd.h"
#include "drivers/mavlink/map_frame.h"
#include "drivers/mavlink/mavlink_channel.h"
#include "drivers/mavlink/mavlink_inertial.h"
#include "drivers/mavlink/mavlink_messages.h"
#include "drivers/mavlink/mavlink_parser.h"
#include "drivers/mavlink/mavlink_range.h"
#include "drivers/mavlink/mavlink_signing.h"
#include "drivers/mavlink/timesync_filter.h"
#include "platform/base/ring_buffer.h"
#include "platform/port/clock.h"
#include "platform/port/range_queue.h"

namespace facet {

enum class PoseMessage : std::uint8_t {
    kOdometry,
    kVision,  ///< VISION_POSITION_ESTIMATE and VISION_SPEED_ESTIMATE
};

/// The clock of the stamps that are sent.
enum class MavlinkTime : std::uint8_t {
    kAutopilot,  ///< the flight controller's, once its offset is found by TIMESYNC; ours until then
    kOwn,        ///< ours; the flight controller may find the offset, since we answer its TIMESYNC
    kStamps,     ///< those of the estimates, as they are: for logs. TIMESYNC is not answered
};

struct MavlinkSigningOptions {
    MavlinkKey key{};
    std::uint8_t link = 0;
    bool accept_unsigned = false;
};

struct MavlinkOptions {
    MavlinkAddress address;
    MavlinkChannelOptions channel;
    PoseMessage message = PoseMessage::kOdometry;
    bool in_map = false;     ///< poses in the map of places (MapFrame), not in the odometry's world
    bool send_lost = false;  ///< poses of an estimator that is lost, with quality -1
    MavlinkTime time = MavlinkTime::kAutopilot;
    std::uint8_t autopilot_component = 1;  ///< MAV_COMP_ID_AUTOPILOT1, of our own system
    std::uint8_t commands_from = 0;        ///< system whose commands are obeyed; 0: none
    std::optional<MavlinkSigningOptions> signing;
    std::optional<MavlinkRangeOptions> range;  ///< its range finder, whose readings give_ranges_to() wants
    std::optional<GlobalOrigin> origin;        ///< what a flight controller without GPS is given as its place
    Duration heartbeat_period = Duration::from_seconds(1.0);
    Duration retry_period = Duration::from_seconds(1.0);  ///< pause before a failed serial line is reopened
};

/// A reading of the flight controller's inertial sensor, as it came.
struct MavlinkReading {
    MavInertial inertial;
    Timestamp arrival;
};

enum class Arming : std::uint8_t { kUnknown, kDisarmed, kArmed };

struct MavlinkCounters {
    std::uint64_t sent = 0;
    std::uint64_t dropped = 0;           ///< frames that the channel did not take
    std::uint64_t lost_poses = 0;        ///< poses held back because the estimator was lost
    std::uint64_t signature_faults = 0;  ///< frames received unsigned, wrongly signed or played back, and ignored
    std::uint64_t commands = 0;          ///< obeyed
    std::uint64_t commands_refused = 0;  ///< from the wrong system, or not possible now
    std::uint64_t reads_failed = 0;
    std::uint64_t ranges = 0;          ///< readings of the range finder that were passed on
    std::uint64_t ranges_refused = 0;  ///< out of its range, invalid, or while the controller's clock was not known
};

/// What is sent, what is answered and when: drivers/mavlink/README.md. A channel that is full or gone is no obstacle:
/// what it does not take is dropped and counted, and a serial line is reopened. Thread-bound, except sent_resets(),
/// signing_time(), hears_version_1(), arming() and take_reset_request(): to its sinks' thread, or, if the flight
/// controller's inertial sensor is used, to that of ImuMavlink. Heap only if open fails.
class MavlinkLink final : public OdometrySink {
public:
    MavlinkLink(KernelIo& io, const Clock& clock, MavlinkOptions options);

    /// See MavlinkChannel. After a failure it is tried again once every retry period, unless the address is invalid.
    Status open(std::string& problem);
    void close() {
        channel_.close();
        is_wanted_ = false;
    }
    bool is_open() const { return channel_.is_open(); }
    /// Waits until something may have arrived.
    void wait(Duration timeout) { channel_.wait(timeout); }

    // The flight controller's inertial sensor:
    /// From now on readings in this message are kept for take_reading(): 256 of them, of which the oldest are dropped.
    /// TIMESYNC is asked for, more often until the offset is known, whatever clock estimates are stamped by.
    void listen_to(MavlinkImuMessage message) { imu_message_ = message; }
    /// Asks for that message at this rate (MAV_CMD_SET_MESSAGE_INTERVAL).
    Status ask_for_readings(double rate_hz) { return ask_for(id_of(*imu_message_), rate_hz); }
    /// What was answered to that; nothing yet.
    std::optional<MavResult> readings_answer() const { return readings_answer_; }
    /// The next one in the order of arrival. @return whether there was one
    bool take_reading(MavlinkReading& reading);
    std::uint64_t readings_dropped() const { return readings_.dropped(); }
    /// The controller's time has restarted: answers to what was asked before are not used.
    void forget_time() {
        timesync_.restart();
        asked_.clear();
        next_question_ = clock_.now();
    }

    /// Readings of the range finder in the options go there from now on; borrowed. TIMESYNC is asked for.
    void give_ranges_to(RangeQueue* queue) { ranges_ = queue; }

    /// Before the first pose: what the reset counter begins at, so that it differs from that of a program before.
    void begin_resets_at(std::uint8_t first) {
        local_changes_ = first;
        sent_resets_.store(first, std::memory_order_relaxed);
    }

    /// Before anything is sent: what the time of signatures begins at if the wall clock is behind, as without a
    /// real-time clock after a reboot: at or after everything that was signed before, which an autopilot has seen.
    void begin_signing_at(std::uint64_t time) {
        if (signer_) {
            signer_->begin_at(time);
        }
    }

    /// Status::kOk also if the pose is held back on purpose.
    Status send(const Odometry& odometry) override;
    void report(const StateChange& change) override;
    Status send_ranges(const ObstacleRanges& ranges) override;
    void service() override;
    /// Answers to TIMESYNC wait that long at most, which the other side takes for half as much of an offset.
    Duration service_period() const override { return Duration::from_seconds(0.002); }

    std::string name() const { return channel_.name(); }
    const MavlinkCounters& counters() const { return counters_; }
    const MavlinkParserCounters& received() const { return parser_.counters(); }
    const TimesyncFilter& timesync() const { return timesync_; }

    // On any thread:
    /// The reset counter of the newest pose.
    std::uint8_t sent_resets() const { return sent_resets_.load(std::memory_order_relaxed); }
    /// Of signatures, what begin_signing_at() has to be given after this program; zero without a key.
    std::uint64_t signing_time() const { return signing_time_.load(std::memory_order_relaxed); }
    /// Whether the autopilot's frames are of version 1 of MAVLink, which is not spoken here.
    bool hears_version_1() const { return hears_version_1_.load(std::memory_order_relaxed); }
    Arming arming() const { return arming_.load(std::memory_order_relaxed); }
    /// Whether the estimator was asked to restart since the last call.
    bool take_reset_request() { return reset_requested_.exchange(false, std::memory_order_relaxed); }

private:
    static constexpr Duration kRangeSilence = Duration::from_seconds(5.0);  ///< then ranges are asked for again

    Status send_message(MavlinkId id);
    Status ask_for(MavlinkId message, double rate_hz);
    void judge_channel(Status status);
    void send_due();
    void receive();
    bool is_trusted(std::span<const std::uint8_t> raw);
    void handle(const MavlinkPacket& packet, Timestamp arrival);
    void handle_timesync(const MavTimesync& timesync, const MavlinkAddress& from, Timestamp arrival);
    void handle_command(const MavCommand& command, const MavlinkPacket& packet);
    void handle_distance(const MavDistance& distance, Timestamp arrival);
    void handle_answer(const MavCommandAck& ack, const MavlinkAddress& from);
    void ask_for_time(Timestamp now);
    void ask_for_ranges(Timestamp now);
    void send_origin(Timestamp now);
    bool hears_ranges() const { return ranges_ != nullptr && options_.range.has_value(); }
    MavResult obey(const MavCommand& command);
    bool is_autopilot(const MavlinkAddress& from) const;
    Timestamp link_time(Timestamp own) const;
    std::uint64_t time_us(Timestamp stamp) const;
    void reopen();

    const Clock& clock_;
    MavlinkOptions options_;
    MavlinkChannel channel_;
    bool is_wanted_ = false;  ///< from open() to close()
    MavlinkParser parser_;
    std::optional<MavlinkSigner> signer_;
    TimesyncFilter timesync_;
    RingBuffer<Timestamp, 8> asked_;  ///< TIMESYNC questions without an answer
    std::optional<MavlinkImuMessage> imu_message_;
    RingBuffer<MavlinkReading, 256> readings_;  ///< a quarter of a second at 1 kHz
    std::optional<MavResult> readings_answer_;
    RangeQueue* ranges_ = nullptr;
    Timestamp next_range_request_;
    MavlinkPayload payload_;
    MavlinkFrame frame_;
    MavlinkPacket packet_;
    std::uint8_t sequence_ = 0;
    MavlinkCounters counters_;
    RetryGate retry_;
    Timestamp next_heartbeat_;
    Timestamp next_question_;
    Timestamp next_text_;
    Timestamp next_origin_;
    bool has_origin_ = false;   ///< the autopilot has reported one since it was heard first
    Timestamp last_autopilot_;  ///< heartbeat
    SinkState state_ = SinkState::kInit;
    StateChange change_;
    bool has_text_ = false;  ///< change_ has not been sent yet
    LocalFrame local_;
    MapFrame map_;
    std::uint8_t local_changes_ = 0;  ///< added to the estimator's reset counter
    std::optional<Odometry> newest_;  ///< the last pose that was good enough to be sent
    std::atomic<Arming> arming_{Arming::kUnknown};
    std::atomic<bool> reset_requested_{false};
    std::atomic<std::uint8_t> sent_resets_{0};
    std::atomic<std::uint64_t> signing_time_{0};
    std::atomic<bool> hears_version_1_{false};
};

}  // namespace facet
