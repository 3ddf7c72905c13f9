// SPDX-License-Identifier: BSD-2-Clause
// places.csv and trajectory_map.tum: where places were known again, and the flight in their map.
#pragma once

#include <string>

#include "app/support/text_file.h"
#include "estimator/api/estimate.h"
#include "mesh/places/place_memory.h"

namespace facet {

/// places.csv: a row for each view compared with the memory and each place that it then recognised; stamp_ns,
/// place_stamp_ns, whether the recognition was accepted, points looked for and points found that agree, the view's
/// pose seen from the place (yaw in rad, x, y, z in m) with standard deviations of its yaw (rad) and position (m), and
/// behind them whether the flight is located, and yaw (rad), x, y, z (m) of map_from_odom. A view that recognised
/// nothing has a row with an empty place_stamp_ns.
/// trajectory_map.tum: poses as in trajectory.tum, carried into the map by what was known then; no lines while the
/// flight is not located. Throws InputError if a file cannot be written. Thread-bound.
class PlaceLog {
public:
    explicit PlaceLog(const std::string& folder);
    /// After each frame. @param is_usable  the estimate is to be used
    void write(const Estimate& estimate, bool is_usable, const PlaceMemory& places);
    void close();

private:
    TextFile places_;
    TextFile trajectory_;
    int stations_ = 0;
};

}  // namespace facet
