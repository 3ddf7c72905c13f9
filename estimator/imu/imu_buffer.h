// SPDX-License-Identifier: BSD-2-Clause
// A bounded history of inertial samples: checked on entry, interpolated and integrated between arbitrary stamps.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>

#include "estimator/api/capacity.h"
#include "estimator/imu/preintegration.h"
#include "platform/base/samples.h"
#include "platform/base/status.h"

namespace facet {

/// What has happened to the samples offered, since construction or clear().
struct ImuBufferCounters {
    std::uint32_t accepted = 0;
    std::uint32_t out_of_order = 0;  ///< rejected: stamp not after the newest (duplicates too)
    std::uint32_t not_finite = 0;    ///< rejected: a rate or a force is NaN or infinite
    std::uint32_t overwritten = 0;   ///< oldest samples lost because the buffer was full
    std::uint32_t gaps = 0;          ///< steps between accepted samples longer than 3.5 nominal periods
};

/// Ring of the newest kMaxImuSamples samples in strictly increasing order of time; full: the oldest is dropped and
/// counted. Usage:
///   ImuBuffer buffer(noise.rate_hz);
///   buffer.push(sample);                                        // every sample
///   buffer.integrate_between(t0, t1, noise, preintegration, &has_gap);
///   buffer.drop_before(t1);
/// About 230 KiB: a member or static, not a local. Thread-bound. No heap.
class ImuBuffer {
public:
    /// A step longer than this many nominal periods is a gap: jitter and one or two lost samples are not.
    static constexpr double kGapPeriods = 3.5;

    explicit ImuBuffer(double rate_hz = 200.0) { clear(rate_hz); }

    /// Forgets samples and counters. @param rate_hz  nominal rate of the IMU (Hz), > 0
    void clear(double rate_hz);

    /// Appends a sample.
    /// @return kInvalidArgument if not finite, kOutOfOrder if its stamp is not after the newest: dropped and counted.
    Status push(const ImuSample& sample);

    bool empty() const { return size_ == 0; }
    int size() const { return size_; }
    /// Stamp of the oldest and newest sample; the buffer must not be empty.
    Timestamp oldest() const { return sample(0).stamp; }
    Timestamp newest() const { return sample(size_ - 1).stamp; }
    /// Sample by age, 0 is the oldest; 0 <= index < size().
    const ImuSample& sample(int index) const;
    const ImuBufferCounters& counters() const { return counters_; }

    /// Sample at a stamp, linearly interpolated between its neighbours (across a gap too).
    /// @return kNotReady if t is after the newest sample or there is none, kNotFound if before the oldest.
    Status interpolate(Timestamp t, ImuSample& out) const;

    /// Calls visit(a, b, gap) for consecutive samples that tile [t0, t1] exactly; the first a and the last b are
    /// interpolated. gap: the Duration between the two samples around the step if that is a gap, else zero.
    /// @return kInvalidArgument if t1 < t0; kNotReady if t1 is after the newest sample or there is none; kNotFound if t0
    ///         is before the oldest: nothing visited.
    template <class Visit>
    Status for_each_step(Timestamp t0, Timestamp t1, Visit visit) const {
        ImuSample a;
        ImuSample end;
        FACET_TRY(t1 < t0 ? Status::kInvalidArgument : interpolate(t1, end));
        FACET_TRY(interpolate(t0, a));
        for (int i = first_after(t0); a.stamp < t1; ++i) {
            const ImuSample& next = sample(i);
            const ImuSample& previous = sample(i - 1);
            const ImuSample& b = next.stamp < t1 ? next : end;
            visit(a, b, is_gap(previous, next) ? next.stamp - previous.stamp : Duration{});
            a = b;
        }
        return Status::kOk;
    }

    /// Adds the samples from exactly t0 to exactly t1 to the preintegration. A gap is bridged by linear interpolation in
    /// steps of a nominal period, with noise raised to what motion of up to about 2 Hz may hide in a gap of its length
    /// (see imu_buffer.cpp), so that the covariance stays honest.
    /// @param preintegration  reset by the caller; untouched unless kOk
    /// @param has_gap         whether a gap touches [t0, t1]; nullptr to skip
    /// @return as for_each_step
    Status integrate_between(Timestamp t0, Timestamp t1, const ImuNoise& noise, Preintegration& preintegration,
                             bool* has_gap = nullptr) const;

    /// Rotation of the body from t1 to t0 (p_Bt0 = q * p_Bt1), from the gyroscope alone: prod Exp((w - bg) dt).
    /// @param gyro_bias  bias to take off (rad/s)
    /// @return as for_each_step
    Status rotation_between(Timestamp t0, Timestamp t1, const Eigen::Vector3d& gyro_bias,
                            Eigen::Quaterniond& q_Bt0_Bt1) const;

    /// Drops samples that are not needed from t on: the last one at or before t stays, so that t can be interpolated.
    void drop_before(Timestamp t);

private:
    bool is_gap(const ImuSample& a, const ImuSample& b) const { return b.stamp - a.stamp > gap_; }
    /// Index of the first sample with a stamp after t; size() if none.
    int first_after(Timestamp t) const;

    std::array<ImuSample, kMaxImuSamples> ring_{};
    int begin_ = 0;  ///< position of the oldest sample in ring_
    int size_ = 0;
    Duration period_;  ///< nominal
    Duration gap_;     ///< longer steps are gaps
    ImuBufferCounters counters_;
};

static_assert(sizeof(ImuBuffer) <= 256 * 1024, "the inertial history is budgeted at 256 KiB");

}  // namespace facet
