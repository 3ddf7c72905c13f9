// SPDX-License-Identifier: BSD-2-Clause
// Writes the estimated trajectory: TUM text and the EuRoC table.
#pragma once

#include <string>

#include "app/support/text_file.h"
#include "estimator/api/estimate.h"

namespace facet {

/// trajectory.tum: "seconds x y z qx qy qz qw", stamps exact to the nanosecond. trajectory.csv: EuRoC's 17 columns
/// t[ns], p, q wxyz, v, gyro bias, accelerometer bias. Pose of B in W. covariance.csv: t[ns] and the 45 entries on and
/// above the diagonal of Estimate::covariance, c00 c01 ... c88, row by row. Throws InputError if a file cannot be
/// written.
class TrajectoryWriter {
public:
    explicit TrajectoryWriter(const std::string& folder);
    void write(const Estimate& estimate);
    void flush();
    void close();

private:
    TextFile tum_;
    TextFile csv_;
    TextFile covariance_;
};

/// Seconds of a stamp with 9 decimals, exact.
std::string tum_seconds(Timestamp stamp);

}  // namespace facet
