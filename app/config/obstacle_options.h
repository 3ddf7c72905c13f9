// SPDX-License-Identifier: BSD-2-Clause
// Which obstacles around the vehicle are reported.
#pragma once

namespace facet {

struct ObstacleOptions {
    double max_range_m = 6.0;  ///< as far as the grid reaches by default: beyond it no direction is known to be free
    double below_m = 0.5;      ///< obstacles from this much below the vehicle
    double above_m = 0.5;      ///< to this much above it count
    double rate_hz = 10.0;
};

}  // namespace facet
