// SPDX-License-Identifier: BSD-2-Clause
// Rotors of a simulated flight: which vibration when.
#include "app/lab/sim/vibration.h"

#include <catch2/catch.hpp>
#include <cmath>

namespace facet::sim::vibration_test {
namespace {

constexpr double kRate_hz = 200.0;
constexpr double kTakeOff_s = 20.0;

/// 40 s without any motion, shaken.
std::vector<ImuRecord> shaken(VibrationKind kind, std::uint64_t seed) {
    std::vector<ImuRecord> records(static_cast<std::size_t>(40.0 * kRate_hz));
    for (std::size_t k = 0; k < records.size(); ++k) {
        records[k].t_s = static_cast<double>(k) / kRate_hz;
    }
    add_vibration(kind, kTakeOff_s, seed, records);
    return records;
}

/// Of the force along x (m/s^2).
double rms(const std::vector<ImuRecord>& records, double from_s, double to_s) {
    double sum = 0.0;
    int count = 0;
    for (const ImuRecord& record : records) {
        if (record.t_s >= from_s && record.t_s < to_s) {
            sum += std::pow(record.sample.a_B.x(), 2);
            ++count;
        }
    }
    return std::sqrt(sum / count);
}

TEST_CASE("Rotors idle before take-off and turn as in flight after it, or idle throughout") {
    const auto flight = shaken(VibrationKind::kFlight, 1);
    CHECK(rms(flight, 0.0, kTakeOff_s) == Approx(0.436).epsilon(0.06));
    CHECK(rms(flight, kTakeOff_s + 0.5, 40.0) == Approx(0.988).epsilon(0.06));
    const auto idle = shaken(VibrationKind::kIdle, 1);
    CHECK(rms(idle, kTakeOff_s, 40.0) == Approx(0.436).epsilon(0.06));
    CHECK(rms(shaken(VibrationKind::kNone, 1), 0.0, 40.0) == 0.0);
    CHECK(flight[5000].state.a_W == Eigen::Vector3d::Zero());
    CHECK(shaken(VibrationKind::kFlight, 1)[5000].sample.a_B == flight[5000].sample.a_B);
    CHECK(shaken(VibrationKind::kFlight, 2)[5000].sample.a_B != flight[5000].sample.a_B);
}

}  // namespace
}  // namespace facet::sim::vibration_test
