// SPDX-License-Identifier: BSD-2-Clause
// Rotors: strength, band and beginning of the vibration.
#include "app/lab/sim/vibration.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>

namespace facet::sim {
namespace {

/// Samples without any motion, so fast that nothing aliases.
std::vector<ImuRecord> silence(double seconds, double rate_hz) {
    std::vector<ImuRecord> records(static_cast<std::size_t>(seconds * rate_hz));
    for (std::size_t k = 0; k < records.size(); ++k) {
        records[k].t_s = static_cast<double>(k) / rate_hz;
    }
    return records;
}

TEST_CASE("Vibration has its strength on each axis, after the beginning only, and its seed") {
    auto records = silence(20.0, 1000.0);
    auto again = records;
    auto other = records;
    add_vibration({}, 5.0, 1, records);
    add_vibration({}, 5.0, 1, again);
    add_vibration({}, 5.0, 2, other);
    Eigen::Array3d accel = Eigen::Array3d::Zero();
    Eigen::Array3d gyro = Eigen::Array3d::Zero();
    int count = 0;
    bool equal = true;
    bool differs = false;
    for (std::size_t k = 0; k < records.size(); ++k) {
        equal = equal && records[k].sample.a_B == again[k].sample.a_B && records[k].sample.w_B == again[k].sample.w_B;
        differs = differs || records[k].sample.a_B != other[k].sample.a_B;
        if (records[k].t_s <= 5.0) {
            CHECK(records[k].sample.a_B.norm() + records[k].sample.w_B.norm() == 0.0);
        } else if (records[k].t_s > 5.5) {
            accel += records[k].sample.a_B.array().square();
            gyro += records[k].sample.w_B.array().square();
            ++count;
        }
    }
    CHECK(equal);
    CHECK(differs);
    for (int axis = 0; axis < 3; ++axis) {
        CHECK(std::sqrt(accel[axis] / count) == Approx(0.5).epsilon(0.1));
        CHECK(std::sqrt(gyro[axis] / count) == Approx(0.02).epsilon(0.1));
    }
}

TEST_CASE("Vibration stays within its band") {
    constexpr double kRate_hz = 1000.0;
    auto records = silence(8.0, kRate_hz);
    add_vibration({}, -1.0, 3, records);
    const auto power = [&](double low_hz, double high_hz) {
        double sum = 0.0;
        for (double f = low_hz; f < high_hz; f += 0.125) {
            std::complex<double> amplitude = 0.0;
            for (const ImuRecord& r : records) {
                amplitude += r.sample.a_B.x() * std::polar(1.0, -2.0 * std::numbers::pi * f * r.t_s);
            }
            sum += std::norm(amplitude);
        }
        return sum;
    };
    const double inside = power(78.0, 122.0);
    CHECK(power(1.0, 70.0) < 0.01 * inside);
    CHECK(power(130.0, 300.0) < 0.01 * inside);
}

}  // namespace
}  // namespace facet::sim
