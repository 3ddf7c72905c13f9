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
/// column each for left_u, left_v, right_u, right_v; and folder/residuals_by_angle.csv: a row for each 5 degrees off
/// the optical axis with number and root mean square of the residuals of either camera. Throws InputError if one cannot
/// be written.
void write_residuals(const VisionResiduals& residuals, const std::string& folder);

}  // namespace facet
