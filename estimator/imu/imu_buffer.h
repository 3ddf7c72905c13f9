// SPDX-License-Identifier: BSD-2-Clause
// A bounded history of inertial samples: checked on entry, interpolated and integrated between arbitrary stamps.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <utility>

#include "estimator/imu/imu_axes.h"
#include "estimator/imu/imu_limits.h"
#include "estimator/imu/preintegration.h"
#include "estimator/imu/stuck_readings.h"
#include "estimator/imu/vibration.h"
#include "estimator/imu/vibration_share.h"
#include "estimator/values/capacity.h"
#include "estimator/values/health.h"
#include "estimator/values/imu_noise.h"
#include "platform/base/samples.h"
#include "platform/base/status.h"

namespace facet {

/// Counts of what happened to the samples offered since construction or clear().
struct ImuBufferCounters {
    std::uint64_t accepted = 0;
    std::uint64_t out_of_order = 0;   ///< rejected: stamp not after the newest (duplicates too)
    std::uint64_t not_finite = 0;     ///< rejected: a rate or a force is NaN or infinite, or the stamp is absurd
    std::uint64_t overwritten = 0;    ///< oldest samples lost because the buffer was full
    std::uint64_t gaps = 0;           ///< steps between accepted samples longer than 3.5 nominal periods
    std::uint64_t clipped_gyro = 0;   ///< accepted samples with a gyroscope axis at its range
    std::uint64_t clipped_accel = 0;  ///< accepted samples with an accelerometer axis at its range

    /// Fills the fields of the health that come from inertial samples.
    void report(Health& health) const {
        health.imu_gaps = gaps;
        health.imu_dropped = out_of_order + not_finite;
        health.imu_clipped = clipped_gyro + clipped_accel;
    }
};

/// What readings would be if the body went on turning and moving at constant rates.
struct SteadyMotion {
    Eigen::Vector3d w_B = Eigen::Vector3d::Zero();  ///< rate (rad/s)
    Eigen::Vector3d a_B = Eigen::Vector3d::Zero();  ///< specific force at its beginning, that of gravity (m/s^2)
    ImuBias bias;                                   ///< that readings have
};

/// How far one step between samples can be trusted.
struct ImuStepQuality {
    Duration gap;              ///< between the two samples around the step if that is a gap, else zero
    ImuAxisMask clipped = 0;   ///< axes that are bridged because a sample at either end is clipped
    StepNoise clip_noise;      ///< of the bridge over them
    ImuAxisMask replaced = 0;  ///< axes with a reading at either end that is not believed
    ImuAxisMask stuck = 0;     ///< axes with stuck readings
    VibrationLevel vibration;
};

/// Properties of the samples of an interval.
struct ImuSpan {
    bool has_gap = false;
    bool is_replaced = false;  ///< readings in it contradict the images
    ImuAxisMask clipped = 0;   ///< axes clipped somewhere in it
    ImuAxisMask stuck = 0;     ///< axes of sensors that hang somewhere in it, see StuckReadings
    /// Largest white noise seen by the vibration meter over the configured one, as densities; 1 if never raised.
    double gyro_noise_ratio = 1.0;
    double accel_noise_ratio = 1.0;
    /// Largest rms of shaking above the band of motion on any axis, right within a factor of two.
    double gyro_vibration_rad_per_s = 0.0;
    double accel_vibration_m_per_s2 = 0.0;
};

/// Ring of the newest kMaxImuSamples samples in strictly increasing order of time; when full, the oldest is dropped and
/// counted. Usage:
///   ImuBuffer buffer(noise.rate_hz, limits);
///   buffer.push(sample);                                        // every sample
///   ImuSpan span;
///   buffer.integrate_between(t0, t1, noise, preintegration, &span);
///
/// Clipping. An axis at 90 % of its range or more is only known to be "at least this much". A run of such readings is
/// bridged by the line between the good readings before and after it; while the run lasts, by the last good one; the
/// other axes are kept. sample(), interpolate() and the others return the bridged value. The true signal may be the
/// bridge (after a spike of the electronics) or lie beyond the range R (in a shock), at about 1.5 R, with the same sign
/// throughout the run: its departure from the bridge has the deviation s = 1.5 R -+ bridge and is fully correlated. It
/// may last for all of the time T between the good readings, and the integral is then wrong by s T, as from white noise
/// of density s sqrt(T). Factors integrated before a run has ended are worth integrating again after it.
///
/// Vibration (see vibration.h). Every sample stores the level of vibration at its time, so that integrating an interval
/// again gives the same noise. If white noise has more than twice the configured variance, the share of it that is
/// believed to accumulate replaces the configured one if it is more, axis by axis. The rest, and tones, come and go
/// within a period: an error of the attitude is added at the beginning and the end of the interval. The velocity's is
/// in no interval. It is the same at the end of one and the beginning of the next, and images see none of it: the
/// velocity that consecutive intervals have in common is the motion's with this ripple.
///
/// Doubt. Readings that something better contradicts can be replaced by those of a steady motion, which are integrated
/// with the noise of what is not known of the true one: see replace().
///
/// About 750 KiB: a member or static, not a local. Thread-bound. No heap.
class ImuBuffer {
public:
    /// A step longer than this many nominal periods is a gap: jitter and one or two lost samples are not.
    static constexpr double kGapPeriods = 3.5;

    /// Stamps beyond 146 years from their epoch are none: differences of others do not overflow.
    static constexpr std::int64_t kMostStamp_ns = std::int64_t{1} << 62U;
    static constexpr bool is_sane(Timestamp t) { return t.ns > -kMostStamp_ns && t.ns < kMostStamp_ns; }

    explicit ImuBuffer(double rate_hz = 200.0, const ImuLimits& limits = {}) { clear(rate_hz, limits); }

    /// Forgets samples and counters.
    /// @param rate_hz  nominal rate of the IMU (Hz), > 0
    /// @param limits   valid limits
    void clear(double rate_hz, const ImuLimits& limits = {});

    /// Forgets samples; what was counted, learnt or set stays.
    void restart();

    /// Sets how much of the vibration accumulates in the integrals from now on; all of it after clear().
    void believe(const VibrationShare& share) { share_ = share; }

    /// Variance of the velocity's ripple at the newest sample, along the axes of B ((m/s)^2): by that much a velocity
    /// that comes from preintegrated samples differs from the motion's. Zero if there is no sample.
    Eigen::Vector3d velocity_ripple() const;
    /// Axes of the sensors that hang at the newest sample, see StuckReadings.
    ImuAxisMask hanging() const { return empty() ? ImuAxisMask{0} : entry(size_ - 1).stuck; }

    /// Appends a sample, even a clipped one. Constant time, except for runs of clipped samples (bridged again).
    /// @return kInvalidArgument if not finite or the stamp is beyond kMostStamp_ns, kOutOfOrder if the stamp is not
    ///         after the newest: dropped and counted.
    Status push(const ImuSample& sample) { return push(sample, limits_.clipped_axes(sample)); }

    /// Likewise of a sample that was corrected; `clipped` are the axes that were at their range as read.
    Status push(const ImuSample& sample, ImuAxisMask clipped);

    /// Replaces the readings of these axes after t0 up to t1; the other axes are as read. What is integrated over them
    /// from now on has the noise of set_replacement_noise() in place of nothing. @param motion  from t0 on
    void replace(Timestamp t0, Timestamp t1, ImuAxisMask axes, const SteadyMotion& motion);
    /// Replaced readings after t0 up to t1 have the values read again, with the replacement noise.
    void show_as_read(Timestamp t0, Timestamp t1);
    /// Readings after t0 up to t1 are as read again.
    void restore(Timestamp t0, Timestamp t1);
    /// Noise, beyond the sensor's own, of all readings that are replaced, and of those that will be.
    void set_replacement_noise(const StepNoise& noise) { replacement_noise_ = noise; }
    /// Exchanges what was read with what is believed in its place, wherever that differs: what is integrated now is as
    /// read. A second call undoes it.
    void exchange_as_read();

    bool empty() const { return size_ == 0; }
    int size() const { return size_; }
    /// Stamp of the oldest and newest sample; the buffer must not be empty.
    Timestamp oldest() const { return sample(0).stamp; }
    Timestamp newest() const { return sample(size_ - 1).stamp; }
    /// Sample by age, 0 is the oldest; 0 <= index < size().
    const ImuSample& sample(int index) const { return entry(index).sample; }
    const ImuBufferCounters& counters() const { return counters_; }

    /// Whether this very sample, stamp and readings, is there.
    bool has(const ImuSample& sample) const;

    /// Sample at a stamp, linearly interpolated between its neighbours (across a gap too).
    /// @return kNotReady if t is after the newest sample or the buffer is empty, kNotFound if before the oldest.
    Status interpolate(Timestamp t, ImuSample& out) const;

    /// Calls visit(a, b, quality) for consecutive samples that tile [t0, t1] exactly; the first a and the last b are
    /// interpolated; quality is an ImuStepQuality.
    /// @return kInvalidArgument if t1 < t0; kNotReady if t1 is after the newest sample or the buffer is empty;
    ///         kNotFound if t0 is before the oldest: nothing visited.
    template <class Visit>
    Status for_each_step(Timestamp t0, Timestamp t1, Visit visit) const {
        ImuSample a;
        ImuSample end;
        FACET_TRY(t1 < t0 ? Status::kInvalidArgument : interpolate(t1, end));
        FACET_TRY(interpolate(t0, a));
        for (int i = first_after(t0); a.stamp < t1; ++i) {
            const ImuSample& next = sample(i);
            const ImuSample& b = next.stamp < t1 ? next : end;
            visit(a, b, quality(i));
            a = b;
        }
        return Status::kOk;
    }

    /// Adds the samples from exactly t0 to exactly t1 to the preintegration. A gap is bridged by linear interpolation
    /// in steps of a nominal period, with noise raised to what motion of up to about 2 Hz may hide in a gap of its
    /// length (see imu_buffer.cpp), so that the covariance stays honest; likewise with clipped runs and vibration (see
    /// above).
    /// To add interval to interval, begin the next where the last one ended: a tone's error counts once at each bound.
    /// @param preintegration  reset by the caller; untouched unless kOk
    /// @param span            properties of the samples that touch [t0, t1], written on kOk; nullptr to skip
    /// @return as for_each_step
    Status integrate_between(Timestamp t0, Timestamp t1, const ImuNoise& noise, Preintegration& preintegration,
                             ImuSpan* span = nullptr) const;

    /// Rotation of the body from t1 to t0 (p_Bt0 = q * p_Bt1), from the gyroscope alone: prod Exp((w - bg) dt).
    /// @param gyro_bias  bias to subtract (rad/s)
    /// @return as for_each_step
    Status rotation_between(Timestamp t0, Timestamp t1, const Eigen::Vector3d& gyro_bias,
                            Eigen::Quaterniond& q_Bt0_Bt1) const;

private:
    static constexpr int kAxes = 6;

    struct Entry {
        ImuSample sample;  ///< clipped axes bridged
        VibrationLevel vibration;
        std::array<float, kAxes> clip_excess;  ///< squared density of what the bridge may hide
        ImuAxisMask clipped;
        ImuAxisMask negative;  ///< axes clipped at the lower end
        ImuAxisMask replaced;
        ImuAxisMask stuck;
        Eigen::Vector3d w_read = Eigen::Vector3d::Zero();  ///< of a sample with replaced axes
        Eigen::Vector3d a_read = Eigen::Vector3d::Zero();
    };

    /// Clipped readings of one axis up to the newest sample.
    struct ClippedRun {
        int length = 0;  ///< 0: the newest sample is good
        bool has_before = false;
        Timestamp before;           ///< stamp of the last good reading
        double before_value = 0.0;  ///< the last good reading
    };

    const Entry& entry(int index) const;
    Entry& entry(int index) { return const_cast<Entry&>(std::as_const(*this).entry(index)); }
    double range(int axis) const { return axis < 3 ? limits_.gyro_range_rad_per_s : limits_.accel_range_m_per_s2; }
    bool is_gap(const ImuSample& a, const ImuSample& b) const { return b.stamp - a.stamp > gap_; }
    /// Of the step from sample index - 1 to sample index.
    ImuStepQuality quality(int index) const;
    /// Index of the first sample with a stamp after t; size() if there is none.
    int first_after(Timestamp t) const;
    void count_clipped(Entry& entry);
    /// Updates the axis's run with the newest sample.
    void follow_run(int axis);
    /// Writes values and noise of a run. @param is_over  the newest sample is the good one after it
    void bridge_run(int axis, bool is_over);

    std::array<Entry, kMaxImuSamples> ring_{};
    int begin_ = 0;  ///< position of the oldest sample in ring_
    int size_ = 0;
    double rate_hz_ = 0.0;
    Duration period_;  ///< nominal
    Duration gap_;     ///< longer steps are gaps
    ImuLimits limits_;
    StepNoise replacement_noise_;
    std::array<ClippedRun, kAxes> runs_{};
    VibrationMeter vibration_;
    StuckReadings stuck_;
    VibrationShare share_;
    ImuBufferCounters counters_;
};

static_assert(sizeof(ImuBuffer) <= 768 * 1024, "the inertial history is budgeted at 768 KiB");

}  // namespace facet
