// SPDX-License-Identifier: BSD-2-Clause
// A flight controller's inertial sensor, over the link that estimates go out by.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "drivers/common/axis_map.h"
#include "drivers/common/device_life.h"
#include "drivers/common/imu_assembler.h"
#include "drivers/mavlink/mavlink_link.h"
#include "drivers/mavlink/mavlink_outbox.h"
#include "platform/port/imu_source.h"

namespace facet {

struct ImuMavlinkOptions {
    MavlinkImuMessage message = MavlinkImuMessage::kHighresImu;
    double rate_hz = 200.0;  ///< that is asked for
    std::uint8_t id = 0;     ///< of the sensor, where the message has several
    AxisMap axes;            ///< of the body that the controller reports in, as x forward, y left, z up
    Duration latency;        ///< from measurement to stamp; subtracted from the stamps
    /// Cut-off frequencies of the controller's second-order low-passes, whose delay is subtracted too (0: none).
    double gyro_filter_hz = 0.0;
    double accel_filter_hz = 0.0;
    Duration retry_period = Duration::from_seconds(0.5);
    Duration silence;  ///< without a sample for this long the sensor counts as silent; zero: never
};

struct ImuMavlinkCounters {
    std::uint64_t requests = 0;        ///< of the message, by SET_MESSAGE_INTERVAL
    std::uint64_t other_sensors = 0;   ///< readings of another id
    std::uint64_t duplicates = 0;      ///< readings that came again, or after a later one: discarded
    std::uint64_t incomplete = 0;      ///< readings of which not all is new: discarded
    std::uint64_t without_time = 0;    ///< readings that came while the controller's clock was not known: discarded
    std::uint64_t stamps_refused = 0;  ///< readings whose stamps cannot be: discarded
    std::uint64_t reboots = 0;         ///< times that the controller's time restarted
};

/// Delay of a second-order Butterworth low-pass at low frequencies: sqrt(2) / (2 pi f_c). Zero without a filter.
Duration low_pass_delay(double cutoff_hz);

/// Readings -> time of this computer -> ImuAssembler -> samples. Readings are stamped by the controller's time since
/// boot, which TIMESYNC brings onto the monotonic clock; a correction of the offset is spread at 0.5 ms a second, so
/// that it never stretches an interval by more than a two-thousandth; at once, but by 20 ms at most, if a reading would
/// be later than its arrival. Until the offset is known, 1.3 s after the start and after a reboot of the controller,
/// there are no samples. The message is asked for until it comes at no less than four fifths of the rate, and again
/// whenever it does not. Samples are lost where the time between two readings has room for more of them.
///
/// next() is what drives the link: it belongs to the thread that calls it, also as a sink, by way of outbox(). Opens
/// the link if it is not open. Thread-bound, except for outbox(). Heap in start() and for problem texts.
class ImuMavlink final : public ImuSource, private Reopenable {
public:
    /// Everything is borrowed and must outlive the source.
    ImuMavlink(MavlinkLink& link, const Clock& clock, const ImuMavlinkOptions& options);

    Status start() override { return life_.start(); }
    /// Closes the link.
    void stop() override;
    Status next(Duration timeout, ImuSample& sample) override;
    ClockDomain clock() const override { return ClockDomain::kMonotonic; }
    SourceCounters counters() const override;
    std::string_view problem() const override { return life_.problem(); }
    double temperature_c() const override { return temperature_c_; }
    const ImuMavlinkCounters& imu_counters() const { return imu_counters_; }
    /// Of the readings, lost ones included; 0 before the first ones.
    double sent_rate_hz() const { return period_ns_ > 0 ? 1e9 / static_cast<double>(period_ns_) : 0.0; }
    /// For the sinks' thread.
    MavlinkOutbox& outbox() { return outbox_; }

private:
    Status open(std::string& problem) override;
    void close() override;
    Status take_until(Timestamp deadline, ImuSample& sample);
    void ask_if_due();
    Status take(const MavlinkReading& reading);
    std::int64_t unwrapped_ns(const MavInertial& inertial, Timestamp arrival) const;
    bool is_reboot(std::int64_t time_ns);
    Timestamp to_host(std::int64_t time_ns, Timestamp arrival);
    void begin_anew();
    void count_lost(std::int64_t time_ns);
    void discard(std::uint64_t& count, const char* why);
    void use(const MavInertial& inertial, Timestamp stamp);

    MavlinkLink& link_;
    const Clock& clock_;
    ImuMavlinkOptions options_;
    Duration gyro_delay_;
    Duration accel_delay_;
    std::string name_;  ///< of the link
    MavlinkOutbox outbox_;
    ImuAssembler assembler_;
    SourceCounters counters_;
    ImuMavlinkCounters imu_counters_;
    DeviceLife life_;
    std::optional<Timestamp> last_request_;
    double temperature_c_ = std::numeric_limits<double>::quiet_NaN();
    // Of the controller's time, in ns:
    std::int64_t newest_ns_ = 0;  ///< reading that was used last
    bool any_ = false;            ///< there is one
    int behind_ = 0;              ///< readings in a row that are far behind it, increasing
    std::int64_t behind_ns_ = 0;  ///< the last of them
    std::int64_t offset_ns_ = 0;  ///< controller's minus ours, as it is applied
    std::int64_t offset_at_ns_ = 0;
    bool has_offset_ = false;
    std::uint64_t steps_ = 0;         ///< of the filter when all this was begun
    std::int64_t period_ns_ = 0;      ///< between readings that follow each other
    int long_gaps_ = 0;               ///< in a row
    std::optional<Timestamp> heard_;  ///< our time: the last reading of this sensor
};

}  // namespace facet
