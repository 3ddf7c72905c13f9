// SPDX-License-Identifier: BSD-2-Clause
// Inertial samples out of tables of text.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace facet {

struct InertialSample {
    std::int64_t stamp_ns = 0;
    std::array<double, 6> values{};  ///< angular rate x y z (rad/s), specific force x y z (m/s^2)
};

struct InertialTable {
    std::vector<InertialSample> samples;  ///< in order of their stamps, which all differ
    std::uint64_t left_out = 0;           ///< rows that are damaged, not finite, or have a stamp that was there
};

/// Reads a table (PlainTable), or two of a gyroscope and an accelerometer, "GYROSCOPE,ACCELEROMETER", which SplitImu
/// puts together. Columns are found by their names, in any order: w_x, gyro_x, angular_velocity.x and their like; a_x,
/// acc_x, linear_acceleration.x and theirs; units in the names, "[deg/s]" and "[g]", are converted. Without names there
/// must be seven columns: stamp, rates, forces; forces before rates are recognised by gravity. The stamps' unit is that
/// of unit_of_stamps; "secs" and "nsecs" may have a column each. Heap: 64 bytes a sample.
/// @param warn  called with what is assumed
/// Throws InputError naming the file and what is missing.
InertialTable read_inertial_table(const std::string& paths, const std::function<void(const std::string&)>& warn);

}  // namespace facet
