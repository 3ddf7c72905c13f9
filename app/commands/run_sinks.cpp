// SPDX-License-Identifier: BSD-2-Clause
#include "app/commands/run_sinks.h"

#include <fmt/core.h>

#include <string>

#include "app/support/console.h"
#include "app/support/input_error.h"

namespace facet {
namespace {

void print_mavlink(const MavlinkLink& link) {
    const MavlinkCounters& out = link.counters();
    const MavlinkParserCounters& in = link.received();
    print_out("mavlink      {} sent, {} dropped; {} received, {} lost, {} corrupt; commands {} obeyed, {} refused\n",
              out.sent, out.dropped, in.packets + in.unknown, in.lost, in.corrupt, out.commands, out.commands_refused);
    if (link.timesync().ready()) {
        print_out("             autopilot's time known to {:.2f} ms\n", link.timesync().sigma_s() * 1e3);
    }
}

void print_can_out(const CanOut& can) {
    const CanOutCounters& out = can.counters();
    print_out("can out      {} estimates in {} frames, {} dropped; queue full {} times, off the bus {}, down {}\n",
              out.estimates, out.frames, out.estimates_dropped, out.queue_full, out.bus_off, out.failures);
}

void print_imu(const ImuMavlink& imu) {
    const ImuMavlinkCounters& c = imu.imu_counters();
    print_out(
        "             its inertial sensor: {:.1f} readings/s, asked for {} times; {} twice or late, {} incomplete, "
        "{} without time, {} of impossible times, {} reboots\n",
        imu.sent_rate_hz(), c.requests, c.duplicates, c.incomplete, c.without_time, c.stamps_refused, c.reboots);
}

void print_ros2_out(const Ros2Output& out) {
    const Ros2OutputCounters& c = out.counters();
    print_out("ros 2        {} poses, {} held back while lost, {} meshes and clouds; {} dropped\n", c.poses.load(),
              c.lost.load(), c.scenes.load(), c.dropped.load());
}

/// @param given  what estimates for it are given to
template <class Sink>
void open_sink(Sink* sink, OdometrySink* given, std::uint8_t first_reset, bool is_in_flight,
               std::vector<OdometrySink*>& sinks) {
    if (sink == nullptr) {
        return;
    }
    std::string problem;
    if (const Status status = sink->open(problem); !ok(status)) {
        if (!is_in_flight || status == Status::kInvalidArgument) {
            throw InputError(problem);
        }
        print_err("warning: {}; begun without it in flight\n", problem);
    }
    if constexpr (requires { sink->begin_resets_at(first_reset); }) {
        sink->begin_resets_at(first_reset);
    }
    sinks.push_back(given);
}

}  // namespace

std::vector<OdometrySink*> open_sinks(Hardware& hardware, const ResetCount& resets, bool is_in_flight) {
    std::vector<OdometrySink*> sinks;
    open_sink(hardware.mavlink(), hardware.mavlink_sink(), resets.first(), is_in_flight, sinks);
    open_sink(hardware.can_out(), hardware.can_out(), resets.first(), is_in_flight, sinks);
    open_sink(hardware.ros2_out(), hardware.ros2_out(), resets.first(), is_in_flight, sinks);
    if (!sinks.empty() && resets.is_restart()) {
        print_err("reset counter begins at {}: the pose starts over\n", resets.first());
    }
    return sinks;
}

void keep_resets(Hardware& hardware, ResetCount& resets) {
    if (hardware.mavlink() == nullptr && hardware.can_out() == nullptr) {
        return;
    }
    // With both it is the one that also counts changes of home and heading.
    const std::uint8_t sent =
        hardware.mavlink() != nullptr ? hardware.mavlink()->sent_resets() : hardware.can_out()->sent_resets();
    if (const std::string problem = resets.keep(sent); !problem.empty()) {
        print_err("warning: the reset counter will start from zero after a restart: {}\n", problem);
    }
}

void look_after(MavlinkLink& link, SigningTime& signing, bool& is_said) {
    if (const std::string problem = signing.keep(link.signing_time()); !problem.empty()) {
        print_err("warning: signatures will be refused after a reboot without a clock: {}\n", problem);
    }
    if (link.hears_version_1() && !is_said) {
        is_said = true;
        print_err(
            "warning: {}: the other side speaks MAVLink 1; set its port to version 2 (ArduPilot: "
            "SERIALn_PROTOCOL 2, PX4: MAV_PROTO_VER 2)\n",
            link.name());
    }
}

void print_sinks(Hardware& hardware) {
    if (hardware.mavlink() != nullptr) {
        print_mavlink(*hardware.mavlink());
    }
    if (hardware.imu_mavlink() != nullptr) {
        print_imu(*hardware.imu_mavlink());
    }
    if (hardware.can_out() != nullptr) {
        print_can_out(*hardware.can_out());
    }
    if (hardware.ros2_out() != nullptr) {
        hardware.ros2_out()->close();
        print_ros2_out(*hardware.ros2_out());
    }
}

}  // namespace facet
