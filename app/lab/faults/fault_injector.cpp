// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/faults/fault_injector.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/lab/faults/image_faults.h"
#include "app/support/rng.h"

namespace facet {
namespace {

// As EuRoC's sensor has them.
constexpr double kInitialGyroBias_rad_per_s = 0.03;
constexpr double kInitialAccelBias_m_per_s2 = 0.06;
// What data sheets allow of scale and misalignment: half a percent, five milliradians.
constexpr double kImuScaleSigma = 5e-3;
constexpr Duration kLongestLead = Duration::from_seconds(100.0);  // of inertial samples before the first frame

/// Random numbers for one fault at one sample.
RandomStream draws(FaultKind kind, std::size_t fault, std::uint64_t seed, std::uint64_t sample) {
    return {hash64(seed, static_cast<std::uint64_t>(kind), fault), sample};
}

Eigen::Vector3d normal_vector(double sigma, RandomStream& random) {
    const double x = random.normal();
    const double y = random.normal();
    return sigma * Eigen::Vector3d(x, y, random.normal());
}

}  // namespace

FaultInjector::FaultInjector(std::vector<Fault> faults, const ImuNoise& noise, Timestamp begin)
    : faults_(std::move(faults)), hits_(faults_.size(), 0), noise_(noise), begin_(begin) {
    for (std::size_t i = 0; i < faults_.size(); ++i) {
        if (faults_[i].kind == FaultKind::kVibration) {
            const VibrationKind kind = faults_[i].values[0] == 0.0 ? VibrationKind::kIdle : VibrationKind::kFlight;
            const std::uint64_t seed = hash64(static_cast<std::uint64_t>(faults_[i].values[1]), i);
            vibrations_.try_emplace(i, vibration_spectrum(kind), seed);
        } else if (faults_[i].kind == FaultKind::kImuScale) {
            RandomStream random(static_cast<std::uint64_t>(faults_[i].values[1]), 0);
            ImuScale::for_each(scales_[i],
                               [&](double& value) { value = faults_[i].values[0] * kImuScaleSigma * random.normal(); });
        }
    }
}

template <class Apply>
void FaultInjector::for_active(FaultKind kind, Timestamp log_stamp, Apply apply) {
    for (std::size_t i = 0; i < faults_.size(); ++i) {
        if (faults_[i].kind == kind && faults_[i].is_active(log_stamp - begin_)) {
            hits_[i] += apply(faults_[i], i) ? 1 : 0;
        }
    }
}

bool FaultInjector::is_active(FaultKind kind, Timestamp log_stamp) {
    bool found = false;
    for_active(kind, log_stamp, [&](const Fault&, std::size_t) { return found = true; });
    return found;
}

Duration FaultInjector::shift(FaultKind kind, Timestamp log_stamp) {
    Duration sum;
    for_active(kind, log_stamp, [&](const Fault& fault, std::size_t) {
        sum = sum + Duration::from_seconds(fault.values[0]);
        return true;
    });
    return sum;
}

/// One step of a bias's random walk; the first draws where it begins.
void FaultInjector::walk(const Fault& fault, std::size_t index) {
    RandomStream random = draws(fault.kind, index, static_cast<std::uint64_t>(fault.values[1]), imu_count_);
    const auto [place, is_new] = biases_.try_emplace(index);
    const double step = 1.0 / std::sqrt(noise_.rate_hz);
    const double gyro = is_new ? kInitialGyroBias_rad_per_s : step * noise_.gyro_walk_rad_per_s2_per_sqrt_hz;
    const double accel = is_new ? kInitialAccelBias_m_per_s2 : step * noise_.accel_walk_m_per_s3_per_sqrt_hz;
    place->second.gyro += normal_vector(fault.values[0] * gyro, random);
    place->second.accel += normal_vector(fault.values[0] * accel, random);
}

/// What an IMU has all the time.
void FaultInjector::shake_and_bias(ImuSample& sample, Duration t) {
    for (std::size_t i = 0; i < faults_.size(); ++i) {
        const Fault& fault = faults_[i];
        if (!fault.is_active_or_before(t)) {
            continue;
        }
        if (fault.kind == FaultKind::kVibration) {
            const RotorVibration::Vector6 shake = vibrations_.at(i).at(std::max(0.0, (t + kLongestLead).seconds()));
            sample.w_B += shake.head<3>();
            sample.a_B += shake.tail<3>();
            ++hits_[i];
        } else if (fault.kind == FaultKind::kImuScale) {
            sample.w_B += scales_.at(i).gyro * sample.w_B;
            sample.a_B += scales_.at(i).accel * sample.a_B;
            ++hits_[i];
        } else if (fault.kind == FaultKind::kImuBias) {
            walk(fault, i);
            sample.w_B += biases_.at(i).gyro;
            sample.a_B += biases_.at(i).accel;
            ++hits_[i];
        }
    }
}

void FaultInjector::change_values(ImuSample& sample, Timestamp log_stamp) {
    for_active(FaultKind::kImuNoise, log_stamp, [&](const Fault& fault, std::size_t i) {
        RandomStream random = draws(fault.kind, i, 1, imu_count_);
        const double factor = fault.values[0] * std::sqrt(noise_.rate_hz);
        sample.w_B += normal_vector(factor * noise_.gyro_noise_rad_per_s_per_sqrt_hz, random);
        sample.a_B += normal_vector(factor * noise_.accel_noise_m_per_s2_per_sqrt_hz, random);
        return true;
    });
    shake_and_bias(sample, log_stamp - begin_);
    for_active(FaultKind::kImuClip, log_stamp, [&](const Fault& fault, std::size_t) {
        const Eigen::Vector3d signs(1.0, -1.0, 1.0);
        sample.a_B = fault.values[0] * signs;
        sample.w_B = fault.values[1] * signs;
        return true;
    });
}

void FaultInjector::add(const ImuSample& sample) {
    ++imu_count_;
    if (!is_active(FaultKind::kImuGap, sample.stamp)) {
        ImuSample out = sample;
        change_values(out, sample.stamp);
        out.stamp = sample.stamp + shift(FaultKind::kClockJump, sample.stamp);
        out_.emplace_back(out);
        for_active(FaultKind::kImuDuplicate, sample.stamp, [&](const Fault& fault, std::size_t i) {
            const bool twice = draws(fault.kind, i, 1, imu_count_).uniform() < fault.values[0];
            if (twice) {
                out_.emplace_back(out);
            }
            return twice;
        });
        newest_imu_ = has_imu_ ? std::max(newest_imu_, out.stamp) : out.stamp;
        has_imu_ = true;
    }
    release(sample.stamp);
}

bool FaultInjector::is_lost(const OwnedFrame& frame) {
    bool lost = !frame.has_left && !frame.has_right;
    for_active(FaultKind::kDropFrames, frame.log_stamp, [&](const Fault& fault, std::size_t i) {
        const auto seed = static_cast<std::uint64_t>(fault.values[1]);
        const bool dropped = draws(fault.kind, i, seed, frame_count_).uniform() < fault.values[0];
        lost = lost || dropped;
        return dropped;
    });
    return lost;
}

void FaultInjector::freeze(OwnedFrame& frame) {
    if (!is_active(FaultKind::kFreeze, frame.log_stamp)) {
        is_frozen_ = false;
        return;
    }
    if (!is_frozen_) {
        is_frozen_ = true;
        frozen_ = frame;
        return;
    }
    frame.left = frozen_.left;
    frame.right = frozen_.right;
    frame.has_left = frozen_.has_left;
    frame.has_right = frozen_.has_right;
}

void FaultInjector::change_images(OwnedFrame& frame) {
    freeze(frame);
    for_active(FaultKind::kFlash, frame.log_stamp, [&](const Fault& fault, std::size_t) {
        overexpose(fault.values[0], frame.left);
        overexpose(fault.values[0], frame.right);
        return true;
    });
    if (is_active(FaultKind::kBlackout, frame.log_stamp)) {
        black_out(hash64(1, frame_count_, 0), frame.left);
        black_out(hash64(1, frame_count_, 1), frame.right);
    }
    frame.has_left = !is_active(FaultKind::kNoLeft, frame.log_stamp) && frame.has_left;
    frame.has_right = !is_active(FaultKind::kNoRight, frame.log_stamp) && frame.has_right;
}

void FaultInjector::add(const StereoFrame& frame) {
    ++frame_count_;
    OwnedFrame owned;
    owned.log_stamp = frame.stamp;
    owned.output_stamp = frame.stamp + shift(FaultKind::kTimeOffset, frame.stamp);
    owned.stamp = owned.output_stamp + shift(FaultKind::kClockJump, frame.stamp);
    owned.has_left = !frame.left.empty();
    owned.has_right = !frame.right.empty();
    copy_image(frame.left, owned.left);
    copy_image(frame.right, owned.right);
    change_images(owned);
    if (!is_lost(owned)) {
        waiting_.push_back(std::move(owned));
    }
    release(frame.stamp);
}

void FaultInjector::release(Timestamp log_now) {
    const auto is_due = [&](const OwnedFrame& frame) {
        return (has_imu_ && frame.stamp <= newest_imu_) || log_now - frame.log_stamp > kMaxWait;
    };
    while (!waiting_.empty() && is_due(waiting_.front())) {
        out_.emplace_back(std::move(waiting_.front()));
        waiting_.pop_front();
    }
}

void FaultInjector::finish() {
    for (OwnedFrame& frame : waiting_) {
        out_.emplace_back(std::move(frame));
    }
    waiting_.clear();
}

}  // namespace facet
