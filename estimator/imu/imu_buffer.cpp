// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/imu/imu_buffer.h"

#include <algorithm>
#include <cmath>

#include "estimator/geometry/so3.h"
#include "platform/base/assert.h"

namespace facet {
namespace {

// Most steps a gap is bridged with: bounds the work of one integration.
constexpr int kMaxGapSteps = 256;
// Where the true value of a clipped reading is expected, in ranges: a half sine with a peak of twice the range averages
// 1.65 while it is clipped, one of 1.2 times the range 1.1.
constexpr double kExcessRanges = 1.5;

// From this multiple of the configured variance on, white noise is raised to what the vibration meter sees: the meter's
// average over 0.25 s scatters by a fifth.
constexpr double kRaiseFrom = 2.0;

double axis_value(const ImuSample& s, int axis) { return axis < 3 ? s.w_B[axis] : s.a_B[axis - 3]; }
double& axis_value(ImuSample& s, int axis) { return axis < 3 ? s.w_B[axis] : s.a_B[axis - 3]; }

/// Sample at t between a and b, a.stamp <= t <= b.stamp.
ImuSample interpolate_linear(const ImuSample& a, const ImuSample& b, Timestamp t) {
    const double share = static_cast<double>((t - a.stamp).ns) / static_cast<double>((b.stamp - a.stamp).ns);
    ImuSample out;
    out.stamp = t;
    out.w_B = a.w_B + share * (b.w_B - a.w_B);
    out.a_B = a.a_B + share * (b.a_B - a.a_B);
    return out;
}

/// Noise, beyond the sensor's own, of samples bridged over gap_s seconds. A signal of amplitude s and angular frequency
/// f departs from its chord by up to s f^2 T^2 / 8, and by s once the gap is long. With f = 2 pi 2 Hz and amplitudes of
/// 0.5 rad/s and 2 m/s^2 that is min(0.5, 10 T^2) rad/s and min(2, 40 T^2) m/s^2, the same throughout the gap: as white
/// noise of equal effect on the integral, a density of that deviation times sqrt(T).
StepNoise noise_in_gap(double gap_s) {
    const double gyro = std::min(0.5, 10.0 * gap_s * gap_s);
    const double accel = std::min(2.0, 40.0 * gap_s * gap_s);
    return {Eigen::Vector3d::Constant(gyro * gyro * gap_s), Eigen::Vector3d::Constant(accel * accel * gap_s)};
}

/// The sensor's noise, raised on axes where more is seen to this share of it.
StepNoise raised(const StepNoise& sensor, const VibrationLevel& seen, const VibrationShare& share, double rate_hz) {
    const auto raise = [rate_hz](const Eigen::Array3d& configured, const Eigen::Array3d& white,
                                 double share) -> Eigen::Vector3d {
        const Eigen::Array3d density = white / rate_hz;
        return (density > kRaiseFrom * configured).select(configured.max(share * density), configured);
    };
    return {raise(sensor.gyro, seen.white().head<3>().cast<double>(), share.gyro),
            raise(sensor.accel, seen.white().tail<3>().cast<double>(), share.accel)};
}

/// The noise of the sensors of these axes.
StepNoise on_axes(const StepNoise& noise, ImuAxisMask axes) {
    StepNoise out;
    out.gyro = (axes & kGyroAxes) != 0 ? noise.gyro : out.gyro;
    out.accel = (axes & kAccelAxes) != 0 ? noise.accel : out.accel;
    return out;
}

/// Adds a step to the properties of its interval.
void note_step(const ImuStepQuality& quality, const StepNoise& sensor, const StepNoise& noise, ImuSpan& span) {
    const auto ratio = [](const Eigen::Vector3d& now, const Eigen::Vector3d& configured) {
        return std::sqrt((now.array() / configured.array()).maxCoeff());
    };
    const auto tone = quality.vibration.tone();
    span.has_gap = span.has_gap || quality.gap > Duration{};
    span.is_replaced = span.is_replaced || quality.replaced != 0;
    span.clipped |= quality.clipped;
    span.stuck |= quality.stuck;
    span.gyro_noise_ratio = std::max(span.gyro_noise_ratio, ratio(noise.gyro, sensor.gyro));
    span.accel_noise_ratio = std::max(span.accel_noise_ratio, ratio(noise.accel, sensor.accel));
    span.gyro_vibration_rad_per_s =
        std::max(span.gyro_vibration_rad_per_s, std::sqrt(static_cast<double>(tone.head<3>().maxCoeff())));
    span.accel_vibration_m_per_s2 =
        std::max(span.accel_vibration_m_per_s2, std::sqrt(static_cast<double>(tone.tail<3>().maxCoeff())));
}

/// Integrates the step from a to b in equal parts of at most a nominal period.
Status integrate_bridged(const ImuSample& a, const ImuSample& b, Duration period, const StepNoise& noise,
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

void ImuBuffer::clear(double rate_hz, const ImuLimits& limits) {
    FACET_ASSERT(rate_hz > 0.0 && rate_hz <= 1e6);
    FACET_ASSERT(ok(limits.validate()));
    limits_ = limits;
    rate_hz_ = rate_hz;
    share_ = {};
    replacement_noise_ = {};
    counters_ = {};
    stuck_ = StuckReadings(rate_hz);
    restart();
    period_ = Duration::from_seconds(1.0 / rate_hz);
    gap_ = Duration::from_seconds(kGapPeriods / rate_hz);
}

void ImuBuffer::restart() {
    vibration_.clear(rate_hz_);
    stuck_.restart();
    runs_.fill({});
    begin_ = 0;
    size_ = 0;
}

Status ImuBuffer::push(const ImuSample& sample, ImuAxisMask clipped) {
    if (!sample.w_B.allFinite() || !sample.a_B.allFinite() || !is_sane(sample.stamp)) {
        ++counters_.not_finite;
        return Status::kInvalidArgument;
    }
    if (!empty() && sample.stamp <= newest()) {
        ++counters_.out_of_order;
        return Status::kOutOfOrder;
    }
    if (!empty() && is_gap(this->sample(size_ - 1), sample)) {
        ++counters_.gaps;
        vibration_.restart();
    }
    if (size_ == kMaxImuSamples) {
        begin_ = (begin_ + 1) % kMaxImuSamples;
        --size_;
        ++counters_.overwritten;
    }
    ++size_;
    ++counters_.accepted;
    Entry& newest = entry(size_ - 1);
    newest = {};
    newest.sample = sample;
    newest.clipped = clipped;
    count_clipped(newest);
    if (newest.clipped == 0) {
        vibration_.add(sample);
    } else {
        vibration_.restart();
    }
    newest.vibration = vibration_.level();
    newest.stuck = stuck_.add(sample, newest.clipped);
    for (int axis = 0; axis < kAxes; ++axis) {
        follow_run(axis);
    }
    return Status::kOk;
}

void ImuBuffer::replace(Timestamp t0, Timestamp t1, ImuAxisMask axes, const SteadyMotion& motion) {
    stuck_.distrust(axes);
    for (int i = first_after(t0); i < size_ && sample(i).stamp <= t1; ++i) {
        Entry& e = entry(i);
        if (e.replaced == 0) {
            e.w_read = e.sample.w_B;
            e.a_read = e.sample.a_B;
        }
        const double dt_s = (e.sample.stamp - t0).seconds();
        const bool has_gyro = (axes & kGyroAxes) != 0;
        const bool has_accel = (axes & kAccelAxes) != 0;
        const Eigen::Vector3d a_B = so3_exp(-dt_s * motion.w_B) * motion.a_B;
        e.sample.w_B = has_gyro ? Eigen::Vector3d(motion.w_B + motion.bias.gyro) : e.w_read;
        e.sample.a_B = has_accel ? Eigen::Vector3d(a_B + motion.bias.accel) : e.a_read;
        e.replaced = axes;
    }
}

void ImuBuffer::show_as_read(Timestamp t0, Timestamp t1) {
    for (int i = first_after(t0); i < size_ && sample(i).stamp <= t1; ++i) {
        Entry& e = entry(i);
        if (e.replaced != 0) {
            e.sample.w_B = e.w_read;
            e.sample.a_B = e.a_read;
        }
    }
}

void ImuBuffer::restore(Timestamp t0, Timestamp t1) {
    stuck_.distrust(0);
    show_as_read(t0, t1);
    for (int i = first_after(t0); i < size_ && sample(i).stamp <= t1; ++i) {
        entry(i).replaced = 0;
    }
}

void ImuBuffer::exchange_as_read() {
    for (int i = 0; i < size_; ++i) {
        Entry& e = entry(i);
        if (e.replaced != 0) {
            e.sample.w_B.swap(e.w_read);
            e.sample.a_B.swap(e.a_read);
        }
    }
}

const ImuBuffer::Entry& ImuBuffer::entry(int index) const {
    FACET_ASSERT(index >= 0 && index < size_);
    return ring_[static_cast<std::size_t>((begin_ + index) % kMaxImuSamples)];
}

void ImuBuffer::count_clipped(Entry& entry) {
    for (int axis = 0; axis < kAxes; ++axis) {
        const auto bit = static_cast<ImuAxisMask>(1U << static_cast<unsigned>(axis));
        if (axis_value(entry.sample, axis) < 0.0) {
            entry.negative |= static_cast<ImuAxisMask>(entry.clipped & bit);
        }
    }
    counters_.clipped_gyro += (entry.clipped & kGyroAxes) != 0 ? 1 : 0;
    counters_.clipped_accel += (entry.clipped & kAccelAxes) != 0 ? 1 : 0;
}

void ImuBuffer::follow_run(int axis) {
    ClippedRun& run = runs_[static_cast<std::size_t>(axis)];
    const Entry& newest = entry(size_ - 1);
    const bool is_clipped = (newest.clipped >> static_cast<unsigned>(axis) & 1U) != 0U;
    if (!is_clipped) {
        if (run.length > 0) {
            bridge_run(axis, true);
            run = {};
        }
        return;
    }
    if (run.length == 0) {
        run.has_before = size_ > 1;
        run.before = run.has_before ? sample(size_ - 2).stamp : newest.sample.stamp;
        run.before_value = run.has_before ? axis_value(sample(size_ - 2), axis) : 0.0;
    }
    ++run.length;
    bridge_run(axis, false);
}

void ImuBuffer::bridge_run(int axis, bool is_over) {
    const ClippedRun& run = runs_[static_cast<std::size_t>(axis)];
    const auto shift = static_cast<unsigned>(axis);
    const int last = is_over ? size_ - 2 : size_ - 1;
    const double length_s = std::max(newest() - run.before, period_).seconds();
    const double after_value = axis_value(sample(size_ - 1), axis);
    for (int i = std::max(0, last - run.length + 1); i <= last; ++i) {
        Entry& e = entry(i);
        double& value = axis_value(e.sample, axis);
        if (run.has_before) {
            const double share = is_over ? (e.sample.stamp - run.before).seconds() / length_s : 0.0;
            value = run.before_value + share * (after_value - run.before_value);
        } else if (is_over) {
            value = after_value;
        }  // else only the reading itself is known
        const double sign = (e.negative >> shift & 1U) != 0U ? -1.0 : 1.0;
        const double sigma = kExcessRanges * range(axis) - sign * value;
        e.clip_excess[static_cast<std::size_t>(axis)] = static_cast<float>(sigma * sigma * length_s);
    }
}

ImuStepQuality ImuBuffer::quality(int index) const {
    const Entry& a = entry(index - 1);
    const Entry& b = entry(index);
    ImuStepQuality out;
    out.gap = is_gap(a.sample, b.sample) ? b.sample.stamp - a.sample.stamp : Duration{};
    out.clipped = a.clipped | b.clipped;
    out.replaced = a.replaced | b.replaced;
    out.stuck = b.stuck;
    out.vibration = b.vibration;
    for (int k = 0; out.clipped != 0 && k < kAxes; ++k) {
        const auto axis = static_cast<std::size_t>(k);
        const double excess = std::max(a.clip_excess[axis], b.clip_excess[axis]);
        (k < 3 ? out.clip_noise.gyro[k] : out.clip_noise.accel[k - 3]) = excess;
    }
    return out;
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

bool ImuBuffer::has(const ImuSample& s) const {
    const int after = first_after(s.stamp);
    if (after == 0) {
        return false;
    }
    const ImuSample& same = sample(after - 1);
    return same.stamp == s.stamp && same.w_B == s.w_B && same.a_B == s.a_B;
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
                                    ImuSpan* span) const {
    const StepNoise sensor = StepNoise::of(noise);
    Preintegration sum = preintegration;
    Status step_status = Status::kOk;
    ImuSpan seen;
    VibrationLevel last;
    FACET_TRY(for_each_step(t0, t1, [&](const ImuSample& a, const ImuSample& b, const ImuStepQuality& quality) {
        if (sum.dt_s() == 0.0) {
            sum.add_edge_error(VibrationMeter::edge_variances(quality.vibration, 0, share_.gyro, rate_hz_));
        }
        const StepNoise usual = raised(sensor, quality.vibration, share_, rate_hz_);
        const StepNoise total = usual + quality.clip_noise + on_axes(replacement_noise_, quality.replaced);
        const Status s = quality.gap > Duration{}
                             ? integrate_bridged(a, b, period_, total + noise_in_gap(quality.gap.seconds()), sum)
                             : sum.integrate(a, b, total);
        step_status = ok(step_status) ? s : step_status;
        note_step(quality, sensor, raised(sensor, quality.vibration, {}, rate_hz_), seen);
        last = quality.vibration;
    }));
    FACET_TRY(step_status);
    sum.add_edge_error(VibrationMeter::edge_variances(last, 0, share_.gyro, rate_hz_));
    preintegration = sum;
    if (span != nullptr) {
        *span = seen;
    }
    return Status::kOk;
}

Eigen::Vector3d ImuBuffer::velocity_ripple() const {
    return empty() ? Eigen::Vector3d::Zero()
                   : VibrationMeter::edge_variances(entry(size_ - 1).vibration, 3, share_.accel, rate_hz_);
}

Status ImuBuffer::rotation_between(Timestamp t0, Timestamp t1, const Eigen::Vector3d& gyro_bias,
                                   Eigen::Quaterniond& q_Bt0_Bt1) const {
    Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
    FACET_TRY(for_each_step(t0, t1, [&](const ImuSample& a, const ImuSample& b, const ImuStepQuality&) {
        const double h = (b.stamp - a.stamp).seconds();
        q = (q * so3_exp(h * (0.5 * (a.w_B + b.w_B) - gyro_bias))).normalized();
    }));
    q_Bt0_Bt1 = q;
    return Status::kOk;
}

}  // namespace facet
