// SPDX-License-Identifier: BSD-2-Clause
// Gyroscope and accelerometer that were recorded apart, as one IMU.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace facet {

/// Collects both, in any order, and gives a sample at each stamp of the gyroscope, with the specific force interpolated
/// linearly between the two of the accelerometer around it: RealSense's sensors differ in rate and phase. Thread-bound.
/// Heap: 32 bytes a reading.
class SplitImu {
public:
    /// Readings of the accelerometer farther apart are a gap.
    static constexpr std::int64_t kGap_ns = 100'000'000;

    struct Reading {
        std::int64_t stamp_ns = 0;
        std::array<double, 3> values{};
    };
    using Give = std::function<void(std::int64_t stamp_ns, const std::array<double, 6>& values)>;

    void add_rates(const Reading& reading) { rates_.push_back(reading); }
    void add_forces(const Reading& reading) { forces_.push_back(reading); }

    /// Gives all samples in order, and forgets them. @return how many of the gyroscope's have no force: before the
    /// first reading of the accelerometer, behind the last, in a gap, or with a stamp that was there before
    std::uint64_t finish(const Give& give);

private:
    std::vector<Reading> rates_;
    std::vector<Reading> forces_;
};

}  // namespace facet
