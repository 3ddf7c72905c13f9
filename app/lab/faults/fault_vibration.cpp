// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/faults/fault_vibration.h"

#include <algorithm>
#include <cmath>

#include "app/support/rng.h"

namespace facet {
namespace {

constexpr Duration kLongestLead = Duration::from_seconds(100.0);  // of inertial samples before the first frame
constexpr Duration kStep{1'000'000};                              // of the integral; the vibration ends at 100 Hz
constexpr double kTimeConstant_s = 1.0;
constexpr Duration kSettling = Duration::from_seconds(8.0 * kTimeConstant_s);

VibrationKind kind_of(const Fault& fault) {
    return fault.values[0] == 0.0 ? VibrationKind::kIdle : VibrationKind::kFlight;
}

}  // namespace

FaultVibration::FaultVibration(const Fault& fault, std::size_t index)
    : factor_(fault.values[2]),
      rotors_(vibration_spectrum(kind_of(fault)), hash64(static_cast<std::uint64_t>(fault.values[1]), index)) {}

RotorVibration::Vector6 FaultVibration::at(Duration t) {
    return factor_ * rotors_.at(std::max(0.0, (t + kLongestLead).seconds()));
}

VibrationAngle::VibrationAngle(const Fault& fault, std::size_t index)
    : vibration_(fault, index), begin_(fault.begin.ns == 0 ? -kSettling : fault.begin) {
    begin();
}

void VibrationAngle::begin() {
    now_ = begin_;
    rate_ = vibration_.at(now_).head<3>();
    angle_.setZero();
}

Eigen::Vector3d VibrationAngle::at(Duration t) {
    if (t < now_) {
        begin();
    }
    if (t < begin_) {
        return Eigen::Vector3d::Zero();
    }
    static const double kKept = std::exp(-kStep.seconds() / kTimeConstant_s);
    while (now_ + kStep <= t) {
        now_ = now_ + kStep;
        const Eigen::Vector3d next = vibration_.at(now_).head<3>();
        angle_ = kKept * angle_ + 0.5 * kStep.seconds() * (rate_ + next);
        rate_ = next;
    }
    return angle_ + (t - now_).seconds() * rate_;
}

}  // namespace facet
