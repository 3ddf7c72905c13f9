// SPDX-License-Identifier: BSD-2-Clause
// Parameters of structural regularities: planes in the window.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "estimator/values/capacity.h"
#include "platform/base/parameter_field.h"
#include "platform/base/status.h"

namespace facet {

/// The modes of [Rosinol19]. Planes are found in the mesh and reported in all of them.
enum class RegularityMode : std::uint8_t {
    kS,    ///< planes do not act on the estimate
    kSp,   ///< an alias of kS in which planes are found and reported, as they are in every mode
    kSpr,  ///< planes are variables, and landmarks are held on them
};

/// What users call the modes, in the order of the enumerators.
inline constexpr std::array<std::string_view, 3> kRegularityModeNames{"s", "sp", "spr"};

constexpr std::string_view to_string(RegularityMode mode) {
    return kRegularityModeNames[static_cast<std::size_t>(mode)];
}

/// Units, ranges and meanings: kRegularityFields below. Except for the mode, all fields matter in kSpr only.
struct RegularityConfig {
    /// A landmark leaves its plane in the window if its distance is above this many standard deviations.
    static constexpr double kLeaveSigmas = 3.0;
    RegularityMode mode = RegularityMode::kS;  ///< chosen with the run, not among the parameters
    double sigma_m = 0.01;
    double height_correlation = 0.1;
    double huber_threshold = 1.5;
    int min_constraints = 20;
    int keep_constraints = 8;
    double min_extent_m = 0.3;
    double join_sigmas = 2.5;
    double max_plane_chi2 = 1.0;
    bool use_pairs = true;
    bool use_gravity = true;

    /// Standard deviation with which the height of each of `count` landmarks on one plane counts (m). If any two
    /// have the correlation c, their mean has the variance sigma^2 (1 + c (count - 1)) / count.
    double weigh_m(int count) const { return sigma_m * std::sqrt(1.0 + height_correlation * std::max(0, count - 1)); }

    /// The condition between fields that does not hold, as a sentence; empty if all hold.
    std::string_view broken_rule() const;
    /// kInvalidArgument if a field is outside its range or a condition between fields does not hold.
    Status validate() const;
};

inline constexpr auto kRegularityFields = std::to_array<ParameterField<RegularityConfig>>({
    {FACET_FIELD(RegularityConfig, sigma_m), "m", 1e-3, 0.5,
     "Standard deviation of a landmark's distance from the plane that holds it: how flat real surfaces are."},
    {FACET_FIELD(RegularityConfig, height_correlation), "-", 0, 1,
     "Correlation of the errors of two landmarks' distances from one plane: surfaces bend, and tracks on them drift "
     "alike."},
    {FACET_FIELD(RegularityConfig, huber_threshold), "-", 0.5, 10,
     "Threshold of Huber's robust loss on a landmark's distance from its plane, in standard deviations."},
    {FACET_FIELD(RegularityConfig, min_constraints), "-", 6, kMaxPlaneLandmarks,
     "Least number of landmarks with which a plane enters the window."},
    {FACET_FIELD(RegularityConfig, keep_constraints), "-", 3, kMaxPlaneLandmarks,
     "A plane that holds fewer landmarks than this leaves the window, unless the marginalization prior depends on it."},
    {FACET_FIELD(RegularityConfig, min_extent_m), "m", 0.01, 10,
     "Least spread (root mean square) of a new plane's landmarks along its narrower side."},
    {FACET_FIELD(RegularityConfig, join_sigmas), "-", 0.5, 10,
     "A landmark joins a plane in the window if its distance is below this many standard deviations."},
    {FACET_FIELD(RegularityConfig, max_plane_chi2), "-", 1, 100,
     "A plane is given up when the mean square of its landmarks' distances, in standard deviations, stays above this."},
    {FACET_FIELD(RegularityConfig, use_pairs), "-", 0, 1,
     "Constrain planes that are nearly parallel to be parallel, and those nearly orthogonal to be orthogonal."},
    {FACET_FIELD(RegularityConfig, use_gravity), "-", 0, 1, "Constrain floors to be level and walls to be upright."},
});

}  // namespace facet
