// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/imu/imu_buffer.h"

#include <algorithm>
#include <cmath>

#include "platform/base/assert.h"

namespace facet {
namespace {

// Most steps a gap is bridged with: bounds the work of one integration.
constexpr int kMaxGapSteps = 256;

/// Sample at t between a and b, a.stamp <= t <= b.stamp.
ImuSample interpolate_linear(const ImuSample& a, const ImuSample& b, Timestamp t) {
    const double share = static_cast<double>((t - a.stamp).ns) / static_cast<double>((b.stamp - a.stamp).ns);
    ImuSample out;
    out.stamp = t;
    out.w_B = a.w_B + share * (b.w_B - a.w_B);
    out.a_B = a.a_B + share * (b.a_B - a.a_B);
    return out;
}

/// Noise of samples bridged over gap_s seconds. A signal of amplitude s and angular frequency f departs from its chord by
/// up to s f^2 T^2 / 8, and by s once the gap is long. With f = 2 pi 2 Hz and amplitudes of 0.5 rad/s and 2 m/s^2 that
/// is min(0.5, 10 T^2) rad/s and min(2, 40 T^2) m/s^2, the same all over the gap: as white noise of equal effect on the
/// integral, a density of that deviation times sqrt(T).
ImuNoise noise_in_gap(const ImuNoise& noise, double gap_s) {
    const double root = std::sqrt(gap_s);
    const double gyro = std::min(0.5, 10.0 * gap_s * gap_s) * root;
    const double accel = std::min(2.0, 40.0 * gap_s * gap_s) * root;
    ImuNoise out = noise;
    out.gyro_noise_rad_per_s_per_sqrt_hz = std::hypot(noise.gyro_noise_rad_per_s_per_sqrt_hz, gyro);
    out.accel_noise_m_per_s2_per_sqrt_hz = std::hypot(noise.accel_noise_m_per_s2_per_sqrt_hz, accel);
    return out;
}

/// Integrates the step from a to b in equal parts of at most a nominal period.
Status integrate_bridged(const ImuSample& a, const ImuSample& b, Duration period, const ImuNoise& noise,
                         Preintegration& preintegration) {
    const Duration span = b.stamp - a.stamp;
    const std::int64_t steps = std::clamp<std::int64_t>((span.ns + period.ns - 1) / period.ns, 1, kMaxGapSteps);
    ImuSample from = a;
    for (std::int64_t k = 1; k <= steps; ++k) {
        const ImuSample to = k == steps ? b : interpolate_linear(a, b, a.stamp + Duration{span.ns / steps * k});
        FACET_TRY(preintegration.integrate(from, to, noise));
        from = to;
    }
    return Status::kOk;
}

}  // namespace

void ImuBuffer::clear(double rate_hz) {
    FACET_ASSERT(rate_hz > 0.0 && rate_hz <= 1e6);
    begin_ = 0;
    size_ = 0;
    counters_ = {};
    period_ = Duration::from_seconds(1.0 / rate_hz);
    gap_ = Duration::from_seconds(kGapPeriods / rate_hz);
}

Status ImuBuffer::push(const ImuSample& sample) {
    if (!sample.w_B.allFinite() || !sample.a_B.allFinite()) {
        ++counters_.not_finite;
        return Status::kInvalidArgument;
    }
    if (!empty() && sample.stamp <= newest()) {
        ++counters_.out_of_order;
        return Status::kOutOfOrder;
    }
    if (!empty() && is_gap(this->sample(size_ - 1), sample)) {
        ++counters_.gaps;
    }
    if (size_ == kMaxImuSamples) {
        begin_ = (begin_ + 1) % kMaxImuSamples;
        --size_;
        ++counters_.overwritten;
    }
    ring_[static_cast<std::size_t>((begin_ + size_) % kMaxImuSamples)] = sample;
    ++size_;
    ++counters_.accepted;
    return Status::kOk;
}

const ImuSample& ImuBuffer::sample(int index) const {
    FACET_ASSERT(index >= 0 && index < size_);
    return ring_[static_cast<std::size_t>((begin_ + index) % kMaxImuSamples)];
}

int ImuBuffer::first_after(Timestamp t) const {
    int low = 0;
    int high = size_;
    while (low < high) {
        const int middle = low + (high - low) / 2;
        if (sample(middle).stamp > t) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    return low;
}

Status ImuBuffer::interpolate(Timestamp t, ImuSample& out) const {
    if (empty() || t > newest()) {
        return Status::kNotReady;
    }
    if (t < oldest()) {
        return Status::kNotFound;
    }
    const int after = first_after(t);
    const ImuSample& before = sample(after - 1);
    out = before.stamp == t ? before : interpolate_linear(before, sample(after), t);
    return Status::kOk;
}

Status ImuBuffer::integrate_between(Timestamp t0, Timestamp t1, const ImuNoise& noise, Preintegration& preintegration,
                                    bool* has_gap) const {
    Preintegration sum = preintegration;
    Status step_status = Status::kOk;
    bool any_gap = false;
    FACET_TRY(for_each_step(t0, t1, [&](const ImuSample& a, const ImuSample& b, Duration gap) {
        const bool in_gap = gap > Duration{};
        any_gap = any_gap || in_gap;
        const Status s = in_gap ? integrate_bridged(a, b, period_, noise_in_gap(noise, gap.seconds()), sum)
                                : sum.integrate(a, b, noise);
        step_status = ok(step_status) ? s : step_status;
    }));
    FACET_TRY(step_status);
    preintegration = sum;
    if (has_gap != nullptr) {
        *has_gap = any_gap;
    }
    return Status::kOk;
}

Status ImuBuffer::rotation_between(Timestamp t0, Timestamp t1, const Eigen::Vector3d& gyro_bias,
                                   Eigen::Quaterniond& q_Bt0_Bt1) const {
    Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
    FACET_TRY(for_each_step(t0, t1, [&](const ImuSample& a, const ImuSample& b, Duration) {
        const double h = (b.stamp - a.stamp).seconds();
        q = (q * so3_exp(h * (0.5 * (a.w_B + b.w_B) - gyro_bias))).normalized();
    }));
    q_Bt0_Bt1 = q;
    return Status::kOk;
}

void ImuBuffer::drop_before(Timestamp t) {
    const int dropped = std::max(0, first_after(t) - 1);
    begin_ = (begin_ + dropped) % kMaxImuSamples;
    size_ -= dropped;
}

}  // namespace facet
