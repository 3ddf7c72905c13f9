// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/mavlink/imu_mavlink.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "drivers/common/stamp_fault.h"

namespace facet {
namespace {

constexpr Duration kLinkPeriod = Duration::from_seconds(0.002);  // how long what is to be sent may wait
constexpr Duration kRequestPeriod = Duration::from_seconds(1.0);
constexpr Duration kSlowRequests = Duration::from_seconds(5.0);  // while readings come, but too few
constexpr double kLeastShare = 0.8;                              // of the rate asked for: less is too few
constexpr std::int64_t kMostAhead_ns = 20'000'000;  // of its arrival, by a link that is slower one way than the other
constexpr int kSettling = 32;                       // readings over which the period is averaged
constexpr int kForNewPeriod = 8;                    // gaps in a row, all long: they are the period
constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr std::int64_t kSlew = 2000;  // a correction of 1 ns takes so many
constexpr int kForReboot = 3;         // readings; frames that overtake each other are never a second apart
constexpr double kMostForce_m_per_s2 = 1000.0;
constexpr double kMostRate_rad_per_s = 100.0;
constexpr std::uint64_t kMostTime_us = 4'000'000'000'000'000;  // more than the time since 1970
constexpr std::int64_t kWrap_ns = 4'294'967'296'000;           // of a count of microseconds in 32 bits

const char* words_for(std::optional<MavResult> answer) {
    if (answer == MavResult::kDenied || answer == MavResult::kUnsupported) {
        return "the flight controller does not send this message: it refuses SET_MESSAGE_INTERVAL";
    }
    return "none of the readings that were asked for has come";
}

}  // namespace

Duration low_pass_delay(double cutoff_hz) {
    return cutoff_hz > 0.0 ? Duration::from_seconds(std::numbers::sqrt2 / (2.0 * std::numbers::pi * cutoff_hz))
                           : Duration{};
}

ImuMavlink::ImuMavlink(MavlinkLink& link, const Clock& clock, const ImuMavlinkOptions& options)
    : link_(link),
      clock_(clock),
      options_(options),
      gyro_delay_(options.latency + low_pass_delay(options.gyro_filter_hz)),
      accel_delay_(options.latency + low_pass_delay(options.accel_filter_hz)),
      name_(link.name()),
      life_(*this, clock, options.retry_period, counters_, options.silence) {
    link_.listen_to(options_.message);
}

Status ImuMavlink::open(std::string& problem) {
    last_request_.reset();
    return link_.is_open() ? Status::kOk : link_.open(problem);
}

/// Estimates and heartbeats go on while the sensor is silent; a port that fails is closed by the link itself.
void ImuMavlink::close() { assembler_.clear(); }

void ImuMavlink::stop() {
    life_.stop();
    link_.close();
}

SourceCounters ImuMavlink::counters() const {
    SourceCounters result = counters_;
    const ImuAssemblerCounters& a = assembler_.counters();
    result.discarded += a.out_of_order + a.unpaired + a.overflowed;
    result.lost += link_.readings_dropped();
    return result;
}

Status ImuMavlink::next(Duration timeout, ImuSample& sample) {
    const Timestamp deadline = clock_.now() + timeout;
    return life_.next(name_, [&] { return take_until(deadline, sample); });
}

Status ImuMavlink::take_until(Timestamp deadline, ImuSample& sample) {
    for (;;) {
        if (ok(assembler_.pop(sample))) {
            return Status::kOk;
        }
        outbox_.pass_on(link_);
        link_.service();
        if (!link_.is_open()) {
            return life_.fail(name_ + ": the port fails");
        }
        ask_if_due();
        for (MavlinkReading reading; link_.take_reading(reading);) {
            FACET_TRY(take(reading));
        }
        if (ok(assembler_.pop(sample))) {
            return Status::kOk;
        }
        const Duration left = deadline - clock_.now();
        if (left.ns <= 0) {
            return Status::kNotReady;
        }
        link_.wait(std::min(left, kLinkPeriod));
    }
}

void ImuMavlink::ask_if_due() {
    const Timestamp now = clock_.now();
    const bool is_heard = heard_ && now - *heard_ < kRequestPeriod;
    if (is_heard && sent_rate_hz() >= kLeastShare * options_.rate_hz) {
        return;
    }
    if (last_request_ && now - *last_request_ < (is_heard ? kSlowRequests : kRequestPeriod)) {
        return;
    }
    last_request_ = now;
    ++imu_counters_.requests;
    (void)link_.ask_for_readings(options_.rate_hz);  // a failure is the link's
    if (!is_heard) {
        life_.refuse(words_for(link_.readings_answer()));
    }
}

/// Older firmware counts microseconds in 32 bits, which begin anew every 72 minutes: what is then a second from now at
/// most is the time meant.
std::int64_t ImuMavlink::unwrapped_ns(const MavInertial& inertial, Timestamp arrival) const {
    const auto time_ns = static_cast<std::int64_t>(inertial.time_us) * 1000;
    const std::int64_t expected_ns = link_.timesync().to_remote(arrival).ns;
    const std::int64_t wraps = (expected_ns - time_ns + kWrap_ns / 2) / kWrap_ns;
    const std::int64_t unwrapped_ns = time_ns + wraps * kWrap_ns;
    const bool is_meant = time_ns < kWrap_ns && wraps > 0 && std::abs(expected_ns - unwrapped_ns) < kSecond_ns;
    return is_meant ? unwrapped_ns : time_ns;
}

/// The controller's time has begun anew: several readings in a row are more than a second behind.
bool ImuMavlink::is_reboot(std::int64_t time_ns) {
    if (!any_ || time_ns > newest_ns_ - kSecond_ns) {
        behind_ = 0;
        return false;
    }
    behind_ = behind_ > 0 && time_ns > behind_ns_ ? behind_ + 1 : 1;
    behind_ns_ = time_ns;
    return behind_ >= kForReboot;
}

/// Nothing that was remembered in the controller's time means anything now.
void ImuMavlink::begin_anew() {
    any_ = has_offset_ = false;
    behind_ = 0;
}

/// Moves the offset that is applied towards what the filter says.
Timestamp ImuMavlink::to_host(std::int64_t time_ns, Timestamp arrival) {
    const std::int64_t wanted_ns = time_ns - link_.timesync().to_own({time_ns}).ns;
    if (!has_offset_) {
        has_offset_ = true;
        offset_ns_ = wanted_ns;
    } else {
        const std::int64_t most_ns = std::abs(time_ns - offset_at_ns_) / kSlew;
        offset_ns_ += std::clamp(wanted_ns - offset_ns_, -most_ns, most_ns);
    }
    offset_at_ns_ = time_ns;
    const std::int64_t ahead_ns = time_ns - offset_ns_ - arrival.ns;
    offset_ns_ += ahead_ns > 0 && ahead_ns <= kMostAhead_ns ? ahead_ns : 0;
    return {time_ns - offset_ns_};
}

/// By the period of readings that follow each other, which may be another than the one that was asked for.
void ImuMavlink::count_lost(std::int64_t time_ns) {
    const std::int64_t gap_ns = time_ns - newest_ns_;
    if (!any_) {
        return;
    }
    if (period_ns_ == 0) {
        period_ns_ = std::llround(1e9 / options_.rate_hz);
    }
    if (2 * gap_ns < 3 * period_ns_) {
        long_gaps_ = 0;
        period_ns_ += (gap_ns - period_ns_) / kSettling;
    } else if (++long_gaps_ >= kForNewPeriod) {
        long_gaps_ = 0;
        period_ns_ = gap_ns;
    } else {
        counters_.lost += static_cast<std::uint64_t>((gap_ns + period_ns_ / 2) / period_ns_ - 1);
    }
}

void ImuMavlink::discard(std::uint64_t& count, const char* why) {
    ++count;
    ++counters_.discarded;
    life_.refuse(why);
}

/// @return kOk, unless it is kCorrupt
Status ImuMavlink::take(const MavlinkReading& reading) {
    const MavInertial& inertial = reading.inertial;
    if (inertial.id != options_.id) {
        ++imu_counters_.other_sensors;
        return Status::kOk;
    }
    heard_ = reading.arrival;
    if (!(inertial.a_B.norm() < kMostForce_m_per_s2 && inertial.w_B.norm() < kMostRate_rad_per_s &&
          inertial.time_us < kMostTime_us)) {
        ++counters_.corrupt;
        life_.refuse("readings that cannot be");
        return Status::kCorrupt;
    }
    if (!inertial.is_complete) {
        discard(imu_counters_.incomplete, "readings without new rates or forces");
        return Status::kOk;
    }
    if (!link_.timesync().ready()) {
        discard(imu_counters_.without_time, "the flight controller's time is not known: TIMESYNC is not answered");
        return Status::kOk;
    }
    if (steps_ != link_.timesync().steps()) {
        steps_ = link_.timesync().steps();
        begin_anew();
    }
    const std::int64_t time_ns = unwrapped_ns(inertial, reading.arrival);
    if (is_reboot(time_ns)) {
        discard(imu_counters_.reboots, "the flight controller's time has restarted");
        link_.forget_time();
        return Status::kOk;
    }
    if (any_ && time_ns <= newest_ns_) {
        discard(imu_counters_.duplicates, "readings whose times do not increase");
        return Status::kOk;
    }
    const Timestamp stamp = to_host(time_ns, reading.arrival);
    if (const char* fault = stamp_fault(stamp, clock_, ClockDomain::kMonotonic); fault != nullptr) {
        discard(imu_counters_.stamps_refused, fault);
        return Status::kOk;
    }
    count_lost(time_ns);
    newest_ns_ = time_ns;
    any_ = true;
    use(inertial, stamp);
    return Status::kOk;
}

void ImuMavlink::use(const MavInertial& inertial, Timestamp stamp) {
    temperature_c_ = inertial.temperature_c;
    life_.refuse("readings that give no sample: stamps that do not increase, or rates without forces");
    (void)assembler_.add_force(stamp - accel_delay_, options_.axes.apply(inertial.a_B));
    (void)assembler_.add_rate(stamp - gyro_delay_, options_.axes.apply(inertial.w_B));
}

}  // namespace facet
