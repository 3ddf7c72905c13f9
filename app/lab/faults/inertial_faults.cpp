// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/faults/inertial_faults.h"

#include <cmath>
#include <limits>

namespace facet {
namespace {

// As EuRoC's sensor has them.
constexpr double kInitialGyroBias_rad_per_s = 0.03;
constexpr double kInitialAccelBias_m_per_s2 = 0.06;
// What data sheets allow of scale and misalignment: half a percent, five milliradians.
constexpr double kImuScaleSigma = 5e-3;

Eigen::Vector3d normal_vector(double sigma, RandomStream& random) {
    const double x = random.normal();
    const double y = random.normal();
    return sigma * Eigen::Vector3d(x, y, random.normal());
}

Eigen::Vector3d turned(AxesError error, const Eigen::Vector3d& value) {
    switch (error) {
        case AxesError::kCycle: return {value.y(), value.z(), value.x()};
        case AxesError::kTurn: return {-value.x(), -value.y(), value.z()};
        case AxesError::kMirror: return {value.x(), -value.y(), value.z()};
    }
    return value;
}

/// Gives the sensors that the fault is of these readings.
void replace(FaultPart part, const Eigen::Vector3d& w_B, const Eigen::Vector3d& a_B, ImuSample& sample) {
    sample.w_B = part == FaultPart::kAccel ? sample.w_B : w_B;
    sample.a_B = part == FaultPart::kGyro ? sample.a_B : a_B;
}

}  // namespace

InertialFaults::InertialFaults(FaultSchedule& schedule, const ImuNoise& noise) : schedule_(schedule), noise_(noise) {
    schedule_.for_all(FaultKind::kVibration,
                      [&](const Fault& fault, std::size_t i) { vibrations_.try_emplace(i, fault, i); });
    schedule_.for_all(FaultKind::kImuScale, [&](const Fault& fault, std::size_t i) {
        RandomStream random(static_cast<std::uint64_t>(fault.values[1]), 0);
        ImuScale::for_each(scales_[i],
                           [&](double& value) { value = fault.values[0] * kImuScaleSigma * random.normal(); });
    });
}

void InertialFaults::turn_axes(ImuSample& sample) {
    schedule_.for_active(FaultKind::kImuAxes, sample.stamp, [&](const Fault& fault, std::size_t) {
        const auto error = word_of<AxesError>(fault, 0);
        sample.w_B = turned(error, sample.w_B);
        sample.a_B = turned(error, sample.a_B);
        return true;
    });
}

void InertialFaults::add_noise(ImuSample& sample, std::uint64_t number) {
    schedule_.for_active(FaultKind::kImuNoise, sample.stamp, [&](const Fault& fault, std::size_t i) {
        RandomStream random = FaultSchedule::draws(fault.kind, i, 1, number);
        const double factor = fault.values[0] * std::sqrt(noise_.rate_hz);
        const auto w = normal_vector(factor * noise_.gyro_noise_rad_per_s_per_sqrt_hz, random);
        const auto a = normal_vector(factor * noise_.accel_noise_m_per_s2_per_sqrt_hz, random);
        replace(word_of<FaultPart>(fault, 1), sample.w_B + w, sample.a_B + a, sample);
        return true;
    });
}

/// One step of a bias's random walk; the first draws where it begins.
void InertialFaults::walk(const Fault& fault, std::size_t index, std::uint64_t number) {
    RandomStream random = FaultSchedule::draws(fault.kind, index, static_cast<std::uint64_t>(fault.values[1]), number);
    const auto [place, is_new] = biases_.try_emplace(index);
    const double step = 1.0 / std::sqrt(noise_.rate_hz);
    const double gyro = is_new ? kInitialGyroBias_rad_per_s : step * noise_.gyro_walk_rad_per_s2_per_sqrt_hz;
    const double accel = is_new ? kInitialAccelBias_m_per_s2 : step * noise_.accel_walk_m_per_s3_per_sqrt_hz;
    place->second.gyro += normal_vector(fault.values[0] * gyro, random);
    place->second.accel += normal_vector(fault.values[0] * accel, random);
}

/// What an IMU has all the time.
void InertialFaults::shake_and_bias(ImuSample& sample, std::uint64_t number) {
    const Duration t = schedule_.since_begin(sample.stamp);
    for (std::size_t i = 0; i < schedule_.faults().size(); ++i) {
        const Fault& fault = schedule_.faults()[i];
        if (!fault.is_active_or_before(t)) {
            continue;
        }
        if (fault.kind == FaultKind::kVibration) {
            const RotorVibration::Vector6 shake = vibrations_.at(i).at(t);
            sample.w_B += shake.head<3>();
            sample.a_B += shake.tail<3>();
        } else if (fault.kind == FaultKind::kImuScale) {
            sample.w_B += scales_.at(i).gyro * sample.w_B;
            sample.a_B += scales_.at(i).accel * sample.a_B;
        } else if (fault.kind == FaultKind::kImuBias) {
            walk(fault, i, number);
            sample.w_B += biases_.at(i).gyro;
            sample.a_B += biases_.at(i).accel;
        } else {
            continue;
        }
        schedule_.count(i);
    }
}

void InertialFaults::clip(ImuSample& sample) {
    schedule_.for_active(FaultKind::kImuClip, sample.stamp, [&](const Fault& fault, std::size_t) {
        const Eigen::Vector3d signs(1.0, -1.0, 1.0);
        replace(word_of<FaultPart>(fault, 2), fault.values[1] * signs, fault.values[0] * signs, sample);
        return true;
    });
}

void InertialFaults::freeze(ImuSample& sample) {
    schedule_.for_active(FaultKind::kImuFreeze, sample.stamp, [&](const Fault& fault, std::size_t i) {
        const ImuSample& first = frozen_.try_emplace(i, sample).first->second;
        replace(word_of<FaultPart>(fault, 0), first.w_B, first.a_B, sample);
        return true;
    });
}

void InertialFaults::lose_values(ImuSample& sample, std::uint64_t number) {
    schedule_.for_active(FaultKind::kImuZero, sample.stamp, [&](const Fault& fault, std::size_t) {
        replace(word_of<FaultPart>(fault, 0), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), sample);
        return true;
    });
    schedule_.for_active(FaultKind::kImuNan, sample.stamp, [&](const Fault& fault, std::size_t i) {
        const bool is_lost = FaultSchedule::draws(fault.kind, i, 1, number).uniform() < fault.values[0];
        const Eigen::Vector3d nan = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
        if (is_lost) {
            replace(word_of<FaultPart>(fault, 1), nan, nan, sample);
        }
        return is_lost;
    });
}

void InertialFaults::change(ImuSample& sample, std::uint64_t number) {
    turn_axes(sample);
    add_noise(sample, number);
    shake_and_bias(sample, number);
    clip(sample);
    freeze(sample);
    lose_values(sample, number);
}

}  // namespace facet
