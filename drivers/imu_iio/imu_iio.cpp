// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/imu_iio/imu_iio.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "drivers/common/stamp_fault.h"

namespace facet {

ImuIio::ImuIio(KernelIo& io, Clock& clock, ImuIioOptions options)
    : io_(io),
      clock_(clock),
      options_(std::move(options)),
      first_(io, options_.device, options_.gyro, {true, !has_two()}),
      second_(io, options_.device, options_.accel, {false, true}),
      assembler_(options_.max_force_gap),
      life_(*this, clock, options_.retry_period, counters_, options_.silence) {
    options_.device.has_stamps = options_.stamps == IioStamps::kKernel;
}

Status ImuIio::open(std::string& problem) {
    assembler_.clear();
    FACET_TRY(first_.open(problem));
    if (has_two()) {
        FACET_TRY(second_.open(problem));
    }
    if (!life_.is_started()) {
        for (const IioSetting& setting : options_.device.settings) {
            if (!first_.has(setting.name) && !(has_two() && second_.has(setting.name))) {
                problem = options_.gyro + ": no attribute '" + setting.name + "' to set";
                return Status::kInvalidArgument;
            }
        }
        warn();
    }
    return Status::kOk;
}

void ImuIio::close() {
    first_.close();
    second_.close();
}

/// Drivers may round rates to those that a chip has, without a word.
void ImuIio::warn() {
    constexpr double kTolerance = 0.01;
    warning_ = options_.stamps == IioStamps::kKernel ? "" : "stamps are those of the reading: for the bench only";
    const double wanted_hz = options_.device.rate_hz;
    for (const IioDevice* device : {&first_, &second_}) {
        const double rate_hz = device->rate_hz();
        if (wanted_hz > 0.0 && rate_hz > 0.0 && std::abs(rate_hz / wanted_hz - 1.0) > kTolerance) {
            warning_ += (warning_.empty() ? "" : "; ") + device->name() + " samples at " +
                        std::string(NumberText(rate_hz).view()) + " Hz instead of " +
                        std::string(NumberText(wanted_hz).view());
        }
    }
}

SourceCounters ImuIio::counters() const {
    SourceCounters result = counters_;
    const ImuAssemblerCounters& a = assembler_.counters();
    result.discarded += a.out_of_order + a.unpaired + a.overflowed;
    return result;
}

/// The wall clock may step or be slewed at any time: both clocks are read together for every scan.
Status ImuIio::to_monotonic(const IioDevice& device, const IioScan& scan, Timestamp& stamp) {
    stamp = {scan.stamp_ns};
    if (options_.stamps == IioStamps::kArrival) {
        stamp = clock_.now();
    } else if (device.clock() == IioClock::kRealtime) {
        const ClockPair pair = clock_.read_pair();
        stamp = pair.monotonic + (stamp - pair.realtime);
    }
    if (const char* fault = stamp_fault(stamp, clock_, ClockDomain::kMonotonic); fault != nullptr) {
        ++counters_.discarded;
        ++stamps_refused_;
        life_.refuse(fault);
        return Status::kNotReady;
    }
    return Status::kOk;
}

Status ImuIio::lose(const IioDevice& device, int error) {
    return life_.fail(device.name() + ": " + std::strerror(error));
}

/// Takes one scan if there is one. @param any  set then
Status ImuIio::take_from(IioDevice& device, bool& any) {
    IioScan scan;
    const Status status = device.read(scan);
    if (status == Status::kIo) {
        return lose(device, device.error());
    }
    if (status == Status::kCorrupt) {
        ++counters_.corrupt;
        life_.refuse("reads that are no whole number of scans");
        return status;
    }
    any = any || ok(status);
    Timestamp stamp;
    if (!ok(status) || !ok(to_monotonic(device, scan, stamp))) {
        return Status::kOk;
    }
    life_.refuse("scans that give no sample: stamps that do not increase, or rates without forces");
    temperature_c_ = scan.temperature_c.value_or(temperature_c_);
    if (scan.force) {
        (void)assembler_.add_force(stamp - options_.latency, options_.axes.apply(*scan.force));
    }
    if (scan.rate) {
        (void)assembler_.add_rate(stamp - options_.latency, options_.axes.apply(*scan.rate));
    }
    return Status::kOk;
}

/// For the device whose scan the next sample lacks.
Status ImuIio::wait(Timestamp deadline) {
    const Duration left{std::max<std::int64_t>((deadline - clock_.now()).ns, 0)};
    if (left.ns == 0) {
        return Status::kNotReady;
    }
    const IioDevice& awaited = has_two() && assembler_.lacks_force() ? second_ : first_;
    const int ready = io_.wait_readable(awaited.fd(), left);
    if (ready < 0) {
        return lose(awaited, -ready);
    }
    return ready == 0 ? Status::kNotReady : Status::kOk;
}

Status ImuIio::next(Duration timeout, ImuSample& sample) {
    const Timestamp deadline = clock_.now() + timeout;
    return life_.next(options_.gyro, [&] { return take_until(deadline, sample); });
}

Status ImuIio::take_until(Timestamp deadline, ImuSample& sample) {
    for (;;) {
        if (ok(assembler_.pop(sample))) {
            return Status::kOk;
        }
        bool any = false;
        FACET_TRY(take_from(first_, any));
        if (has_two()) {
            FACET_TRY(take_from(second_, any));
        }
        if (!any) {
            FACET_TRY(wait(deadline));
        }
    }
}

}  // namespace facet
