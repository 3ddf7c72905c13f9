// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/mavlink/mavlink_link.h"

#include <algorithm>
#include <utility>

namespace facet {
namespace {

constexpr Duration kTextPeriod = Duration::from_seconds(0.5);  // a state that flutters does not fill the line
constexpr Duration kQuestionPeriod = Duration::from_seconds(0.1);
constexpr Duration kFirstQuestions = Duration::from_seconds(0.02);  // while readings cannot be used without the answers
constexpr Duration kAutopilotSilence = Duration::from_seconds(5.0);
constexpr Duration kOriginPeriod = Duration::from_seconds(1.0);
constexpr double kRangeRate_hz = 50.0;
constexpr int kReadsAtATime = 16;
constexpr std::size_t kReadSize = 512;

std::uint8_t mav_state(SinkState state) {
    switch (state) {
        case SinkState::kInit: return kMavStateCalibrating;
        case SinkState::kTracking:
        case SinkState::kDegraded: return kMavStateActive;
        case SinkState::kLost: return kMavStateCritical;
    }
    return kMavStateCritical;
}

MavSeverity severity_of(SinkState state) {
    return state == SinkState::kLost       ? MavSeverity::kCritical
           : state == SinkState::kDegraded ? MavSeverity::kWarning
                                           : MavSeverity::kInfo;
}

}  // namespace

MavlinkLink::MavlinkLink(KernelIo& io, const Clock& clock, MavlinkOptions options)
    : clock_(clock), options_(std::move(options)), channel_(io, options_.channel), retry_(options_.retry_period) {
    if (options_.signing) {
        signer_.emplace(options_.signing->key, options_.signing->link);
    }
}

Status MavlinkLink::open(std::string& problem) {
    const Status status = channel_.open(problem);
    is_wanted_ = status != Status::kInvalidArgument;
    next_heartbeat_ = next_question_ = next_text_ = clock_.now();
    retry_.close(clock_.now());
    return status;
}

/// A serial line that was unplugged, or what could not be opened at first.
void MavlinkLink::reopen() {
    if (!channel_.is_open() && is_wanted_ && retry_.pass(clock_.now())) {
        std::string unused;
        (void)channel_.open(unused);  // if it fails, so do the writes, which are counted
    }
}

/// Sends payload_.
Status MavlinkLink::send_message(MavlinkId id) {
    reopen();
    pack_mavlink(id, {payload_.data(), payload_.size()}, options_.address, sequence_++, frame_);
    if (signer_) {
        signer_->sign(frame_, clock_.read_pair().realtime);
        signing_time_.store(signer_->time(), std::memory_order_relaxed);
    }
    const Status status = channel_.write({frame_.data(), frame_.size()});
    ++(ok(status) ? counters_.sent : counters_.dropped);
    judge_channel(status);
    return status;
}

/// A serial line that fails is closed, to be opened again.
void MavlinkLink::judge_channel(Status status) {
    if (status == Status::kIo && channel_.is_serial() && channel_.is_open()) {
        channel_.close();
        retry_.close(clock_.now());
    }
}

/// The time that the other side is told: the same in stamps and in answers to TIMESYNC, or it would correct twice.
Timestamp MavlinkLink::link_time(Timestamp own) const {
    return options_.time == MavlinkTime::kAutopilot && timesync_.ready() ? timesync_.to_remote(own) : own;
}

std::uint64_t MavlinkLink::time_us(Timestamp stamp) const {
    return static_cast<std::uint64_t>(std::max<std::int64_t>(link_time(stamp).ns / 1000, 0));
}

Status MavlinkLink::send(const Odometry& odometry) {
    send_due();
    if (odometry.quality < 0 && !options_.send_lost) {
        ++counters_.lost_poses;
        return Status::kOk;
    }
    const Odometry shown = options_.in_map ? map_.carried(odometry) : odometry;
    FrdOdometry frd;
    FACET_TRY(to_frd(shown, local_, frd));
    newest_ = shown;
    frd.reset_counter = static_cast<std::uint8_t>(frd.reset_counter + local_changes_);
    sent_resets_.store(frd.reset_counter, std::memory_order_relaxed);
    if (options_.message == PoseMessage::kOdometry) {
        encode_odometry(frd, time_us(frd.stamp), payload_);
        return send_message(MavlinkId::kOdometry);
    }
    encode_vision_position(frd, time_us(frd.stamp), payload_);
    FACET_TRY(send_message(MavlinkId::kVisionPositionEstimate));
    encode_vision_speed(frd, time_us(frd.stamp), payload_);
    return send_message(MavlinkId::kVisionSpeedEstimate);
}

Status MavlinkLink::send_ranges(const ObstacleRanges& ranges) {
    encode_obstacles(ranges, time_us(ranges.stamp), payload_);
    return send_message(MavlinkId::kObstacleDistance);
}

void MavlinkLink::report(const StateChange& change) {
    state_ = change.state;
    change_ = change;
    has_text_ = true;
    send_due();
}

void MavlinkLink::service() {
    reopen();
    judge_channel(channel_.flush());
    receive();
    hears_version_1_.store(parser_.counters().version_1 > 0, std::memory_order_relaxed);
    send_due();
}

/// Heartbeat, text and question whose time has come. Failures are counted.
void MavlinkLink::send_due() {
    const Timestamp now = clock_.now();
    if (now >= next_heartbeat_) {
        next_heartbeat_ = now + options_.heartbeat_period;
        encode(MavHeartbeat{.system_status = mav_state(state_)}, payload_);
        (void)send_message(MavlinkId::kHeartbeat);
        if (now - last_autopilot_ > kAutopilotSilence) {
            arming_.store(Arming::kUnknown, std::memory_order_relaxed);
            has_origin_ = false;  // it may come back without what it knew
        }
    }
    if (has_text_ && now >= next_text_) {
        next_text_ = now + kTextPeriod;
        has_text_ = false;
        encode_status_text(severity_of(state_), change_.text.data(), payload_);
        (void)send_message(MavlinkId::kStatusText);
    }
    if (hears_ranges() && arming() != Arming::kUnknown && now >= next_range_request_) {
        ask_for_ranges(now);
    }
    if ((options_.time == MavlinkTime::kAutopilot || imu_message_ || hears_ranges()) && now >= next_question_) {
        ask_for_time(now);
    }
    if (options_.origin && arming() != Arming::kUnknown && !has_origin_ && now >= next_origin_) {
        send_origin(now);
    }
}

/// Until the autopilot reports an origin: it does not acknowledge, and takes none before its filter has started.
void MavlinkLink::send_origin(Timestamp now) {
    next_origin_ = now + kOriginPeriod;
    encode_set_origin(*options_.origin, options_.address.system, time_us(now), payload_);
    (void)send_message(MavlinkId::kSetGpsGlobalOrigin);
}

void MavlinkLink::ask_for_time(Timestamp now) {
    next_question_ = now + (imu_message_ && !timesync_.ready() ? kFirstQuestions : kQuestionPeriod);
    const MavTimesync question{0, now.ns, {options_.address.system, options_.autopilot_component}};
    encode(question, payload_);
    if (ok(send_message(MavlinkId::kTimesync))) {
        asked_.push(now);
    }
}

Status MavlinkLink::ask_for(MavlinkId message, double rate_hz) {
    MavCommand command{.command = kMavCmdSetMessageInterval,
                       .target = {options_.address.system, options_.autopilot_component}};
    command.param[0] = static_cast<float>(message);
    command.param[1] = static_cast<float>(1e6 / rate_hz);
    encode(command, payload_);
    return send_message(MavlinkId::kCommandLong);
}

/// While none come.
void MavlinkLink::ask_for_ranges(Timestamp now) {
    next_range_request_ = now + kRangeSilence;
    (void)ask_for(MavlinkId::kDistanceSensor, kRangeRate_hz);  // a failure is counted
}

bool MavlinkLink::take_reading(MavlinkReading& reading) {
    if (readings_.empty()) {
        return false;
    }
    reading = readings_.front();
    readings_.pop_front();
    return true;
}

void MavlinkLink::receive() {
    std::array<std::uint8_t, kReadSize> bytes;
    for (int i = 0; i < kReadsAtATime && channel_.is_open(); ++i) {
        std::size_t size = 0;
        const Status status = channel_.read(bytes, size);
        if (status == Status::kNotReady) {
            return;
        }
        if (!ok(status)) {
            ++counters_.reads_failed;
            judge_channel(status);
            return;
        }
        const Timestamp arrival = clock_.now();
        (void)parser_.feed(std::span(bytes).first(size));  // takes it all: what is left of before is one frame at most
        for (std::span<const std::uint8_t> raw; ok(parser_.next(packet_, raw));) {
            if (is_trusted(raw)) {
                handle(packet_, arrival);
            }
        }
        if (!channel_.is_serial()) {
            parser_.end_datagram();
        }
    }
}

/// Without a key every frame is; signatures are then not looked at.
bool MavlinkLink::is_trusted(std::span<const std::uint8_t> raw) {
    if (!signer_) {
        return true;
    }
    packet_.is_signed = (raw[2] & kMavlinkSigned) != 0 && ok(signer_->verify(raw, clock_.read_pair().realtime));
    const bool is_plain = (raw[2] & kMavlinkSigned) == 0;
    const bool trusted = packet_.is_signed || (is_plain && options_.signing->accept_unsigned);
    counters_.signature_faults += trusted ? 0 : 1;
    return trusted;
}

}  // namespace facet
