// SPDX-License-Identifier: BSD-2-Clause
// Writes the estimated trajectory: TUM text and the EuRoC table.
#pragma once

#include <string>

#include "app/support/text_file.h"
#include "estimator/api/estimate.h"

namespace facet {

/// A line of a file in the TUM form, "seconds x y z qx qy qz qw", with its end. Reentrant. Heap.
std::string tum_line(Timestamp stamp, const Se3& pose);

/// Poses are those of B in W. Throws InputError if a file cannot be written.
///   trajectory.tum   "seconds x y z qx qy qz qw", stamps exact to the nanosecond
///   trajectory.csv   EuRoC's 17 columns: t[ns], p, q wxyz, v, gyro bias, accelerometer bias
///   covariance.csv   t[ns] and the 45 entries c00 c01 ... c88 on and above the diagonal of Estimate::covariance, row
///                    by row
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

}  // namespace facet
