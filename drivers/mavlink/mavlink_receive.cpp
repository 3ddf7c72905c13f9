// SPDX-License-Identifier: BSD-2-Clause
// What MavlinkLink makes of the messages it receives.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/mavlink/mavlink_link.h"

namespace facet {

bool MavlinkLink::is_autopilot(const MavlinkAddress& from) const {
    return from == MavlinkAddress{options_.address.system, options_.autopilot_component};
}

void MavlinkLink::handle(const MavlinkPacket& packet, Timestamp arrival) {
    switch (packet.id) {
        case MavlinkId::kHeartbeat: {
            const MavHeartbeat heartbeat = decode_heartbeat(packet.payload);
            if (is_autopilot(packet.from) && heartbeat.autopilot != kMavAutopilotInvalid) {
                const bool armed = (heartbeat.base_mode & kMavModeArmed) != 0;
                arming_.store(armed ? Arming::kArmed : Arming::kDisarmed, std::memory_order_relaxed);
                last_autopilot_ = arrival;
            }
            break;
        }
        case MavlinkId::kTimesync: handle_timesync(decode_timesync(packet.payload), packet.from, arrival); break;
        case MavlinkId::kCommandLong:
        case MavlinkId::kCommandInt: handle_command(decode_command(packet), packet); break;
        case MavlinkId::kCommandAck: handle_answer(decode_command_ack(packet.payload), packet.from); break;
        case MavlinkId::kDistanceSensor:
            if (hears_ranges() && is_autopilot(packet.from)) {
                handle_distance(decode_distance(packet.payload), arrival);
            }
            break;
        case MavlinkId::kGpsGlobalOrigin: has_origin_ = has_origin_ || is_autopilot(packet.from); break;
        default:
            if (imu_message_ && packet.id == id_of(*imu_message_) && is_autopilot(packet.from)) {
                readings_.push({decode_inertial(packet), arrival});
            }
            break;
    }
}

void MavlinkLink::handle_timesync(const MavTimesync& timesync, const MavlinkAddress& from, Timestamp arrival) {
    const bool is_for_all = timesync.target == MavlinkAddress{0, 0};
    if (!is_autopilot(from) || options_.time == MavlinkTime::kStamps ||
        (!is_for_all && timesync.target != options_.address)) {
        return;
    }
    if (timesync.tc1_ns != 0) {
        for (std::size_t i = 0; i < asked_.size(); ++i) {
            if (asked_[i].ns == timesync.ts1_ns) {
                asked_.pop_front(i + 1);  // answers to older questions are late
                (void)timesync_.add({timesync.ts1_ns}, arrival, {timesync.tc1_ns});  // judged there
                return;
            }
        }
        return;  // the answer to somebody else
    }
    if (options_.time == MavlinkTime::kAutopilot && !timesync_.ready()) {
        return;  // the time that we would answer with is about to change
    }
    // As the question: to all if that was. Zero would make it a question again.
    encode(MavTimesync{std::max<std::int64_t>(link_time(clock_.now()).ns, 1), timesync.ts1_ns,
                       is_for_all ? MavlinkAddress{0, 0} : from},
           payload_);
    (void)send_message(MavlinkId::kTimesync);  // a failure is counted
}

/// Stamped by the controller's time since boot, to the millisecond; never later than its arrival.
void MavlinkLink::handle_distance(const MavDistance& distance, Timestamp arrival) {
    constexpr std::int64_t kMillisecond_ns = 1'000'000;
    constexpr double kMetresPerCm = 0.01;
    const MavlinkRangeOptions& range = *options_.range;
    if (distance.id != range.id) {
        return;
    }
    next_range_request_ = arrival + kRangeSilence;
    if (!distance.is_of_ground() || !timesync_.ready()) {
        ++counters_.ranges_refused;
        return;
    }
    const Timestamp stamp = timesync_.to_own({kMillisecond_ns * distance.time_ms});
    const RangeSample sample{std::min(stamp, arrival) - range.latency,
                             range.place_B + kMetresPerCm * distance.distance_cm * range.down_B};
    ++(ok(ranges_->push(sample)) ? counters_.ranges : counters_.ranges_refused);
}

void MavlinkLink::handle_answer(const MavCommandAck& ack, const MavlinkAddress& from) {
    const bool is_for_us = ack.target == options_.address || ack.target == MavlinkAddress{0, 0};
    if (is_autopilot(from) && is_for_us && ack.command == kMavCmdSetMessageInterval) {
        readings_answer_ = ack.result;
    }
}

void MavlinkLink::handle_command(const MavCommand& command, const MavlinkPacket& packet) {
    if (command.target != options_.address) {
        return;
    }
    MavResult result = MavResult::kDenied;
    if (options_.commands_from != 0 && packet.from.system == options_.commands_from) {
        result = packet.id == MavlinkId::kCommandInt ? MavResult::kCommandLongOnly : obey(command);
    }
    ++(result == MavResult::kAccepted ? counters_.commands : counters_.commands_refused);
    encode(MavCommandAck{command.command, result, packet.from}, payload_);
    (void)send_message(MavlinkId::kCommandAck);
}

/// The estimator may begin anew in the air. The frame that poses are given in changes on the ground only.
MavResult MavlinkLink::obey(const MavCommand& command) {
    const bool may_move_frame = arming() == Arming::kDisarmed && newest_.has_value();
    switch (command.command) {
        case kMavCmdUser1: reset_requested_.store(true, std::memory_order_relaxed); return MavResult::kAccepted;
        case kMavCmdDoSetHome:
            if (command.param[0] != 1.0F) {
                return MavResult::kDenied;  // a place by latitude and longitude
            }
            if (!may_move_frame) {
                return MavResult::kTemporarilyRejected;
            }
            local_ = with_home_at(local_, *newest_);
            break;
        case kMavCmdUser2:
            if (!(std::abs(command.param[0]) <= 360.0F)) {
                return MavResult::kDenied;
            }
            if (!may_move_frame) {
                return MavResult::kTemporarilyRejected;
            }
            local_ = with_heading(local_, *newest_, static_cast<double>(command.param[0]) * std::numbers::pi / 180.0);
            break;
        default: return MavResult::kUnsupported;
    }
    ++local_changes_;
    return MavResult::kAccepted;
}

}  // namespace facet
