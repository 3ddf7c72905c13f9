// SPDX-License-Identifier: BSD-2-Clause
// Writes histograms of a run's residuals: residuals.csv.
#pragma once

#include <array>
#include <string>

#include "estimator/values/residuals.h"

namespace facet {

/// One coordinate of one camera, by the name it has in files.
struct NamedResiduals {
    const char* name;
    const ResidualHistogram* histogram;
};
std::array<NamedResiduals, 4> named_residuals(const VisionResiduals& residuals);

/// Writes folder/residuals.csv: a row for each bin with its middle (px) and the number of observations in it, in a
/// column each for left_u, left_v, right_u, right_v. Throws InputError if it cannot be written.
void write_residuals(const VisionResiduals& residuals, const std::string& folder);

}  // namespace facet
