// SPDX-License-Identifier: BSD-2-Clause
#include "tests/hil/inject/injector.h"

#include <linux/can/error.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <ctime>
#include <system_error>

namespace facet::hil {
namespace {

/// From the call of play() to the first sample.
constexpr Duration kStart = Duration::from_seconds(0.2);
constexpr std::uint32_t kBurst = 10;

void step_wall_clock(std::int64_t seconds) {
    timespec now{};
    ::clock_gettime(CLOCK_REALTIME, &now);
    now.tv_sec += seconds;
    if (::clock_settime(CLOCK_REALTIME, &now) != 0) {
        throw std::system_error(errno, std::generic_category(), "the wall clock cannot be set");
    }
}

}  // namespace

Injector::Injector(const InjectorOptions& options, const Recording& recording, Clock& clock)
    : options_(options),
      recording_(recording),
      clock_(clock),
      left_(options.left, recording.width, recording.height, options.pixels.format),
      right_(options.right, recording.width, recording.height, options.pixels.format),
      trigger_(options.trigger_pull) {
    if (is_on_can(options.imu)) {
        can_.emplace(options.can_interface);
    } else if (options.imu == ImuKind::kIio) {
        iio_.emplace();
    } else {
        data_ready_.emplace(options.data_ready_pull);
        spi_.emplace();
    }
    if (options.light) {
        light_.emplace(*options.light);
    }
    plan();
}

void Injector::plan() {
    // A DroneCAN node sends at the end of the interval whose middle is the stamp.
    const Duration delay{options_.imu == ImuKind::kDroneCan ? options_.imu_period.ns / 2 : 0};
    for (std::size_t i = 0; i < recording_.imu.size(); ++i) {
        actions_.push_back({recording_.imu[i].stamp + delay, What::kImu, i});
    }
    plan_frames();
    for (std::size_t i = 0; i < options_.faults.faults().size(); ++i) {
        const Fault& fault = options_.faults.faults()[i];
        actions_.push_back({recording_.frames.front().stamp + fault.begin, What::kFaultBegin, i});
        if (const Timestamp end = recording_.frames.front().stamp + fault.end; end < frames_.back().stamp) {
            actions_.push_back({end, What::kFaultEnd, i});
        }
    }
    std::stable_sort(actions_.begin(), actions_.end(), [](const Action& a, const Action& b) { return a.due < b.due; });
}

void Injector::send_spi(std::size_t index, bool damaged) {
    const ImuSample& sample = recording_.imu[index];
    if (options_.imu == ImuKind::kBmi088) {
        const std::size_t before = index > 0 ? index - 1 : 0;
        const Eigen::Vector3d force = force_at(recording_.imu, before, sample.stamp - kBmiForceAge);
        spi_->set_burst(bmi_registers(sample, force, imu_count_));
    } else if (options_.imu == ImuKind::kIcm42688) {
        auto packet = icm_packet(sample, static_cast<std::uint16_t>(sample.stamp.ns / 1000 & 0xFFFF));
        packet[0] ^= damaged ? 0x40 : 0;
        spi_->push_packet(packet);
    } else {
        auto burst = adis_burst(sample, static_cast<std::uint16_t>(imu_count_));
        burst[5] ^= damaged ? 0x10 : 0;
        spi_->set_burst(burst);
    }
    // A chip that nobody has set up makes no edges.
    const bool merged = active(FaultKind::kReadyMerged, sample.stamp) && imu_count_ % 2 == 0;
    if (!merged && spi_->makes_edges()) {
        data_ready_->pulse();
    }
}

void Injector::send_can(const ImuSample& sample, bool damaged) {
    auto frames = options_.imu == ImuKind::kDroneCan
                      ? dronecan_frames(sample, options_.imu_period, static_cast<std::uint8_t>(imu_count_ & 0x1F))
                      : openimu_frames(sample);
    if (damaged) {
        frames.front().bytes[5] ^= 0x10;
    }
    for (const CanFrame& frame : frames) {
        const bool lost = active(FaultKind::kCanLoss, sample.stamp) && can_frames_ / kBurst % 3 == 2;
        ++can_frames_;
        if (!lost) {
            can_->send(frame);
        }
    }
}

void Injector::send_imu(std::size_t index) {
    const ImuSample& sample = recording_.imu[index];
    ++imu_count_;
    for (const FaultKind silent : {FaultKind::kImuSilent, FaultKind::kBusOff, FaultKind::kImuBrownOut}) {
        if (active(silent, sample.stamp)) {
            return;
        }
    }
    const bool damaged = active(FaultKind::kImuDamaged, sample.stamp) && imu_count_ % 2 == 0;
    if (can_) {
        send_can(sample, damaged);
    } else if (iio_) {
        iio_->measure(iio_counts(sample));
    } else {
        send_spi(index, damaged);
    }
    ++report_.imu_sent;
}

/// Of the inertial sensor.
void Injector::switch_power(bool fails) {
    spi_->set_dead(fails);
    if (!fails) {
        spi_->power_on();
    }
}

/// Those that happen once, at their beginning.
void Injector::strike(FaultKind kind, Child& child) {
    switch (kind) {
        case FaultKind::kClock30s: step_wall_clock(30); break;
        case FaultKind::kClock1h: step_wall_clock(3600); break;
        case FaultKind::kClockBack10s: step_wall_clock(-10); break;
        case FaultKind::kSinksHang: child.hang("facet-sinks"); break;
        case FaultKind::kStopped: child.send_signal(SIGSTOP); break;
        case FaultKind::kKilled: child.send_signal(SIGKILL); break;
        case FaultKind::kPowerCut: report_.power_cut = true; break;
        default: break;
    }
}

/// Those that are a change of state rather than of what is sent.
void Injector::switch_fault(const Fault& fault, bool begins, Child& child) {
    switch (fault.kind) {
        case FaultKind::kUnplugged:
            if (begins) {
                left_.unplug();
            } else {
                left_.plug();
                count_anew_ = true;
            }
            unplugged_ = begins;
            break;
        case FaultKind::kImuDead:
            if (spi_) {
                spi_->set_dead(begins);
            }
            break;
        case FaultKind::kImuBrownOut:
            if (spi_) {
                switch_power(begins);
            }
            break;
        case FaultKind::kImuUnplugged:
            if (iio_) {
                begins ? iio_->unplug() : iio_->plug();
            }
            break;
        case FaultKind::kBusOff:
            if (can_) {
                can_->send_error(begins ? CAN_ERR_BUSOFF : CAN_ERR_RESTARTED);
            }
            break;
        case FaultKind::kCanDown:
            if (can_) {
                can_->set_up(!begins);
            }
            break;
        default:
            if (begins) {
                strike(fault.kind, child);
            }
            break;
    }
}

void Injector::act(std::size_t number, Child& child) {
    const Action action = actions_[number];
    switch (action.what) {
        case What::kEdge:
            trigger_.pulse();
            if (light_) {
                expose(number);
            }
            break;
        case What::kExtraEdge: trigger_.pulse(); break;
        case What::kLeft: send_frame(action.index, true); break;
        case What::kRight: send_frame(action.index, false); break;
        case What::kImu: send_imu(action.index); break;
        case What::kFaultBegin: switch_fault(options_.faults.faults()[action.index], true, child); break;
        case What::kFaultEnd: switch_fault(options_.faults.faults()[action.index], false, child); break;
    }
}

InjectorReport Injector::play(Child& child) {
    report_.shift = clock_.now() + kStart - actions_.front().due;
    report_.first_frame = recording_.frames.front().stamp;
    for (std::size_t i = 0; i < actions_.size(); ++i) {
        const Timestamp due = actions_[i].due + report_.shift;
        const bool is_frame = actions_[i].what == What::kLeft;
        clock_.sleep_until(due);
        act(i, child);
        // Afterwards: in virtual time every look at the clock moves it on by a fraction of a microsecond.
        report_.latest = std::max(report_.latest, clock_.now() - due);
        if (report_.power_cut) {
            return report_;
        }
        if (is_frame && !child.tend(clock_.now())) {
            break;
        }
    }
    clock_.sleep(Duration::from_seconds(0.3));
    return report_;
}

}  // namespace facet::hil
