// SPDX-License-Identifier: BSD-2-Clause
// Levels of the ground under the vehicle: which one a range finder's reading is of, and which readings are of none.
#pragma once

#include "estimator/window/range_config.h"
#include "estimator/window/window_state.h"

namespace facet {

/// A reading says that the ground it has met, h = e_z . (p + R m) (factors/ground_factor), is as high as the other
/// readings of its level: r = (h - f_l) / sigma, where the level's height f_l is a variable of the window, of which
/// nothing is known at first. So changes of height are held as long as the level is the same, not the height itself.
/// The ground rises and falls: what the prior knows of a level wanders by RangeConfig::kUnevenness with the distance
/// flown over it. All functions: reentrant, no heap.

/// Adds a reading to the newest keyframe. It is of a known level if the change of height since that one's last reading,
/// ten seconds ago at most, agrees within three standard deviations, preferably of the level read last; else of a new
/// one, in the place of the one read longest ago. An edge of a table thus begins a new level, and behind the table the
/// old one goes on.
/// @param first_row            of the levels among the globals
/// @param p_B                  the point of the ground (m)
/// @param climb_sigma_m_per_s  of the vertical speed, by which the change of height is uncertain
void add_ground_reading(const RangeConfig& config, int first_row, const Eigen::Vector3d& p_B,
                        double climb_sigma_m_per_s, WindowState& state);

/// After an optimization: forgets the level of the newest reading if its readings, five or more, are not those of level
/// ground (mean squared residual above 4): a ramp, stairs in small steps.
/// @return whether they are not
bool drop_uneven_ground(const RangeConfig& config, int first_row, WindowState& state);

}  // namespace facet
