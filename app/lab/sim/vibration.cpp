// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/sim/vibration.h"

#include <algorithm>
#include <cmath>

#include "app/support/rng.h"

namespace facet::sim {
namespace {

constexpr double kSpinUp_s = 0.5;

}  // namespace

void add_vibration(VibrationKind kind, double take_off_s, std::uint64_t seed, std::span<ImuRecord> records) {
    if (kind == VibrationKind::kNone) {
        return;
    }
    RotorVibration idle(vibration_spectrum(VibrationKind::kIdle), hash64(seed, 1));
    RotorVibration flight(vibration_spectrum(VibrationKind::kFlight), hash64(seed, 2));
    for (ImuRecord& record : records) {
        const double share =
            kind == VibrationKind::kFlight ? std::clamp((record.t_s - take_off_s) / kSpinUp_s, 0.0, 1.0) : 0.0;
        RotorVibration::Vector6 shake = RotorVibration::Vector6::Zero();
        if (share < 1.0) {
            shake += std::sqrt(1.0 - share) * idle.at(record.t_s);
        }
        if (share > 0.0) {
            shake += std::sqrt(share) * flight.at(record.t_s);
        }
        record.sample.w_B += shake.head<3>();
        record.sample.a_B += shake.tail<3>();
    }
}

}  // namespace facet::sim
