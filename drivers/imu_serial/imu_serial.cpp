// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/imu_serial/imu_serial.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "drivers/common/serial_line.h"
#include "drivers/imu_serial/microstrain.h"
#include "drivers/imu_serial/vectornav.h"
#include "drivers/imu_serial/xsens.h"

namespace facet {
namespace {

std::unique_ptr<SerialProtocol> protocol_of(SerialSensor sensor) {
    switch (sensor) {
        case SerialSensor::kXsens: return std::make_unique<Xsens>();
        case SerialSensor::kMicroStrain: return std::make_unique<MicroStrain>();
        case SerialSensor::kVectorNav: break;
    }
    return std::make_unique<VectorNav>();
}

}  // namespace

ImuSerial::ImuSerial(KernelIo& io, Clock& clock, ImuSerialOptions options)
    : io_(io),
      clock_(clock),
      options_(std::move(options)),
      protocol_(protocol_of(options_.sensor)),
      assembler_(options_.max_force_gap, ImuSerial::clock()),
      life_(*this, clock, options_.retry_period, counters_, options_.silence) {}

Status ImuSerial::open(std::string& problem) {
    stream_.clear();
    assembler_.clear();
    protocol_->reset();
    return open_serial_line(io_, options_.device, options_.baud, fd_, problem);
}

void ImuSerial::close() {
    if (fd_ >= 0) {
        (void)io_.close(fd_);
    }
    fd_ = -1;
}

SourceCounters ImuSerial::counters() const {
    SourceCounters result = counters_;
    const ImuAssemblerCounters& a = assembler_.counters();
    result.discarded += a.out_of_order + a.unpaired + a.overflowed;
    return result;
}

Status ImuSerial::lose(int error) {
    return life_.fail(options_.device + ": " + (error == 0 ? "closed" : std::strerror(error)));
}

Status ImuSerial::receive(Timestamp deadline) {
    const Duration left{std::max<std::int64_t>((deadline - clock_.now()).ns, 0)};
    const int ready = io_.wait_readable(fd_, left);
    if (ready <= 0) {
        return ready == 0 ? Status::kNotReady : lose(-ready);
    }
    const std::span<std::uint8_t> room = stream_.room();
    const std::int64_t size = io_.read(fd_, room.data(), room.size());
    if (size == -EAGAIN) {
        return Status::kNotReady;
    }
    if (size <= 0) {
        return lose(static_cast<int>(-size));
    }
    stream_.take(static_cast<std::size_t>(size));
    return Status::kOk;
}

Status ImuSerial::take_packet(std::span<const std::uint8_t> packet) {
    SerialReading reading;
    protocol_->read(packet, reading);
    counters_.lost += reading.lost;
    temperature_c_ = reading.temperature_c.value_or(temperature_c_);
    if (!reading.time_ns || (!reading.rate && !reading.force)) {
        life_.refuse(protocol_->outputs());
        return Status::kOk;
    }
    if ((reading.rate && !reading.rate->allFinite()) || (reading.force && !reading.force->allFinite())) {
        life_.refuse("numbers that are none");
        return Status::kCorrupt;
    }
    life_.refuse("packets that give no sample: stamps that do not increase, or rates without forces");
    const Timestamp stamp = Timestamp{*reading.time_ns} - options_.latency;
    if (reading.force) {
        (void)assembler_.add_force(stamp, options_.axes.apply(*reading.force));
    }
    if (reading.rate) {
        (void)assembler_.add_rate(stamp, options_.axes.apply(*reading.rate));
    }
    return Status::kOk;
}

Status ImuSerial::next(Duration timeout, ImuSample& sample) {
    const Timestamp deadline = clock_.now() + timeout;
    return life_.next(options_.device, [&] { return take_until(deadline, sample); });
}

Status ImuSerial::take_until(Timestamp deadline, ImuSample& sample) {
    for (;;) {
        if (ok(assembler_.pop(sample))) {
            return Status::kOk;
        }
        std::span<const std::uint8_t> packet;
        const Status status = stream_.next(*protocol_, packet);
        if (!ok(status) && stream_.passed_over() > 0) {
            life_.refuse("bytes that are no packets: another protocol or baud rate");
        }
        if (status == Status::kNotReady) {
            FACET_TRY(receive(deadline));
        } else if (!ok(status) || !ok(take_packet(packet))) {
            ++counters_.corrupt;
            return Status::kCorrupt;
        }
    }
}

}  // namespace facet
