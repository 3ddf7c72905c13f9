// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/imu_can/imu_can.h"

#include <linux/can/error.h>

#include <cstring>
#include <utility>

#include "drivers/common/stamp_fault.h"

namespace facet {
ImuCan::ImuCan(KernelIo& io, const Clock& clock, CanDecoder& decoder, ImuCanOptions options)
    : clock_(clock),
      decoder_(decoder),
      options_(std::move(options)),
      socket_(io),
      assembler_(options_.max_force_gap, ImuCan::clock()),
      life_(*this, clock, options_.retry_period, counters_, options_.silence) {}

Status ImuCan::open(std::string& problem) {
    decoder_.reset();
    assembler_.clear();
    const std::vector<CanFilter> filters = decoder_.filters();
    return socket_.open(options_.socket, filters, problem);
}

SourceCounters ImuCan::counters() const {
    SourceCounters result = counters_;
    const ImuAssemblerCounters& a = assembler_.counters();
    result.discarded += a.out_of_order + a.unpaired + a.overflowed;
    return result;
}

Status ImuCan::take_error(const CanFrame& frame) {
    if ((frame.id & CAN_ERR_BUSOFF) != 0) {
        ++can_counters_.bus_off;
        decoder_.reset();
        return life_.fail_without_closing(options_.socket.interface +
                                          ": bus-off; the kernel restarts the controller if restart-ms is set");
    }
    can_counters_.error_frames += (frame.id & CAN_ERR_RESTARTED) != 0 ? 0 : 1;
    return Status::kNotReady;
}

/// The wall clock may step or be slewed at any time: both clocks are read together for every frame. Frames that waited
/// in the socket while it stepped get stamps that are ahead, or behind the one before: neither is used.
Status ImuCan::to_monotonic(Timestamp& stamp) {
    const ClockPair pair = clock_.read_pair();
    if (stamp.ns == 0) {
        ++can_counters_.unstamped;
        stamp = pair.monotonic;
        return Status::kOk;
    }
    stamp = pair.monotonic + (stamp - pair.realtime);
    if (const char* fault = stamp_fault(stamp, clock_, ClockDomain::kMonotonic); fault != nullptr) {
        ++counters_.discarded;
        ++can_counters_.stamps_refused;
        life_.refuse(fault);
        return Status::kNotReady;
    }
    return Status::kOk;
}

Status ImuCan::take(CanFrame& frame) {
    if (frame.error) {
        return take_error(frame);
    }
    if (!options_.socket.hardware_stamps) {
        FACET_TRY(to_monotonic(frame.stamp));
    } else if (frame.stamp.ns == 0) {
        ++can_counters_.unstamped;
        frame.stamp = clock_.read_pair().realtime;
    }
    CanMeasurement measurement;
    const Status decoded = decoder_.decode(frame, measurement);
    if (decoded == Status::kCorrupt) {
        ++counters_.corrupt;
        life_.refuse("frames that cannot be decoded");
    }
    if (!ok(decoded)) {
        return decoded == Status::kCorrupt ? decoded : Status::kNotReady;
    }
    life_.refuse("frames that give no sample: stamps that do not increase, or rates without forces");
    counters_.lost += measurement.lost;
    if (measurement.temperature_c == measurement.temperature_c) {
        temperature_c_ = measurement.temperature_c;
    }
    const Timestamp stamp = frame.stamp - measurement.age - options_.latency;
    if (measurement.force) {
        (void)assembler_.add_force(stamp, options_.axes.apply(*measurement.force));
    }
    if (measurement.rate) {
        (void)assembler_.add_rate(stamp, options_.axes.apply(*measurement.rate));
    }
    return Status::kNotReady;
}

Status ImuCan::next(Duration timeout, ImuSample& sample) {
    const Timestamp deadline = clock_.now() + timeout;
    return life_.next(options_.socket.interface, [&] { return take_until(deadline, sample); });
}

Status ImuCan::take_until(Timestamp deadline, ImuSample& sample) {
    for (;;) {
        if (ok(assembler_.pop(sample))) {
            return Status::kOk;
        }
        const Duration left = deadline - clock_.now();
        CanFrame frame;
        const Status received = socket_.receive(left.ns > 0 ? left : Duration{}, frame);
        can_counters_.overflows = socket_.overflows();
        if (received == Status::kIo) {
            return life_.fail(options_.socket.interface + ": " + std::strerror(socket_.error()));
        }
        if (received == Status::kCorrupt) {
            ++counters_.corrupt;
            life_.refuse("frames of an impossible size");
        }
        FACET_TRY(received);
        if (const Status taken = take(frame); taken != Status::kNotReady) {
            return taken;
        }
    }
}

}  // namespace facet
