// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/imu_spi/imu_spi.h"

#include <algorithm>
#include <utility>

namespace facet {

ImuSpi::ImuSpi(SpiImuChip& chip, TriggerSource* data_ready, Clock& clock, ImuSpiOptions options)
    : chip_(chip),
      data_ready_(data_ready),
      clock_(clock),
      options_(std::move(options)),
      assembler_(options_.max_force_gap, ImuSpi::clock()),
      life_(*this, clock, options_.retry_period, counters_, options_.silence) {}

Status ImuSpi::open(std::string& problem) {
    assembler_.clear();
    corrupt_in_a_row_ = 0;
    // A chip that is reopened in flight is not tested again.
    const SelfTest test = life_.is_started() ? SelfTest::kSkip : SelfTest::kRun;
    std::string words;
    if (const Status status = chip_.configure(test, words); !ok(status)) {
        problem = options_.name + ": " + words;
        return status;
    }
    if (data_ready_ != nullptr) {
        if (const Status status = data_ready_->start(); !ok(status)) {
            problem = options_.name + ": data-ready line: " + std::string(data_ready_->problem());
            return status;
        }
        // Edges from before the chip was set up are meaningless.
        TriggerEdge stale;
        while (ok(data_ready_->next({}, stale))) {
        }
    }
    next_poll_ = clock_.now();
    return Status::kOk;
}

Status ImuSpi::start() { return life_.start(); }

void ImuSpi::stop() {
    if (data_ready_ != nullptr) {
        data_ready_->stop();
    }
    life_.stop();
}

Status ImuSpi::fail(std::string_view problem) { return life_.fail(options_.name + ": " + std::string(problem)); }

SourceCounters ImuSpi::counters() const {
    SourceCounters result = counters_;
    const ImuAssemblerCounters& a = assembler_.counters();
    result.discarded += a.out_of_order + a.unpaired + a.overflowed;
    return result;
}

Status ImuSpi::wait_for_edge(Timestamp deadline, TriggerEdge& edge) {
    const Duration left{std::max<std::int64_t>((deadline - clock_.now()).ns, 0)};
    if (data_ready_ == nullptr) {
        if (next_poll_ > clock_.now() + left) {
            clock_.sleep(left);
            return Status::kNotReady;
        }
        clock_.sleep_until(next_poll_);
        edge = {clock_.now(), ++polls_, true};
        next_poll_ = edge.stamp + options_.poll_period;
        return Status::kOk;
    }
    FACET_TRY(data_ready_->next(left, edge));
    while (chip_.newest_edge_only() && ok(data_ready_->next({}, edge))) {
    }
    return Status::kOk;
}

void ImuSpi::take(const SpiMeasurement& measurement) {
    counters_.lost += measurement.lost;
    if (measurement.temperature_c == measurement.temperature_c) {
        temperature_c_ = measurement.temperature_c;
    }
    const Timestamp stamp = measurement.stamp - options_.latency;
    if (measurement.force) {
        (void)assembler_.add_force(stamp, options_.axes.apply(*measurement.force));
    }
    if (measurement.rate) {
        (void)assembler_.add_rate(stamp, options_.axes.apply(*measurement.rate));
    }
}

Status ImuSpi::read(const TriggerEdge& edge) {
    SpiMeasurements measurements;
    const Status status = chip_.read(edge, measurements);
    if (!ok(status) && status != Status::kNotReady && status != Status::kCorrupt) {
        return fail(chip_.problem());
    }
    for (const SpiMeasurement& measurement : measurements) {
        take(measurement);
    }
    if (status == Status::kCorrupt) {
        ++counters_.corrupt;
        life_.refuse("bad readings");
        if (++corrupt_in_a_row_ >= options_.max_corrupt) {
            return fail(std::to_string(corrupt_in_a_row_) + " bad readings in a row");
        }
        return Status::kCorrupt;
    }
    if (!measurements.empty()) {
        corrupt_in_a_row_ = 0;
        life_.refuse("readings that give no sample: stamps that do not increase, or rates without forces");
    }
    return Status::kNotReady;
}

Status ImuSpi::next(Duration timeout, ImuSample& sample) {
    const Timestamp deadline = clock_.now() + timeout;
    return life_.next(options_.name, [&] { return take_until(deadline, sample); });
}

Status ImuSpi::take_until(Timestamp deadline, ImuSample& sample) {
    for (;;) {
        if (ok(assembler_.pop(sample))) {
            return Status::kOk;
        }
        TriggerEdge edge;
        const Status waited = wait_for_edge(deadline, edge);
        if (waited == Status::kIo) {
            return fail("data-ready line: " + std::string(data_ready_->problem()));
        }
        FACET_TRY(waited);
        if (const Status taken = read(edge); taken != Status::kNotReady) {
            return taken;
        }
    }
}

}  // namespace facet
