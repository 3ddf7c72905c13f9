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
    kSp,   ///< landmarks on planes have weights of their own if WindowConfig::published_weights is set; otherwise as kS
    kSpr,  ///< planes are variables, and landmarks are held on them
};

/// What users call the modes, in the order of the enumerators.
inline constexpr std::array<std::string_view, 3> kRegularityModeNames{"s", "sp", "spr"};

constexpr std::string_view to_string(RegularityMode mode) {
    return kRegularityModeNames[static_cast<std::size_t>(mode)];
}

/// Units, ranges and meanings: kRegularityFields below. Except for the mode, all fields matter in kSpr only.
struct RegularityConfig {
    /// A landmark joins a plane in the window if its distance is below this many standard deviations.
    static constexpr double kJoinSigmas = 2.5;
    /// Least spread (root mean square) of a new plane's landmarks along its narrower side (m).
    static constexpr double kMinExtent_m = 0.3;
    /// A plane that holds fewer landmarks than this leaves the window, unless the marginalization prior depends on it.
    static constexpr int kKeepConstraints = 8;
    /// Least number of landmarks with which a plane enters the window.
    static constexpr int kMinConstraints = 20;
    /// A landmark leaves its plane in the window if its distance is above this many standard deviations.
    static constexpr double kLeaveSigmas = 3.0;
    RegularityMode mode = RegularityMode::kS;  ///< chosen with the run, not among the parameters
    double sigma_m = 0.01;
    bool use_gravity = true;
    // Not among the parameters:
    /// Correlation of the errors of two landmarks' distances from one plane: surfaces bend, and tracks on them drift
    /// alike.
    double height_correlation = 0.1;
    double huber_threshold = 1.5;  ///< of Huber's loss on a landmark's distance from its plane (standard deviations)
    double max_plane_chi2 = 1.0;  ///< a plane is given up when the mean square of its landmarks' distances, in standard
                                  ///< deviations, stays above this

    /// Standard deviation with which the height of each of `count` landmarks on one plane counts (m). If any two
    /// have the correlation c, their mean has the variance sigma^2 (1 + c (count - 1)) / count.
    double weigh_m(int count) const { return sigma_m * std::sqrt(1.0 + height_correlation * std::max(0, count - 1)); }

    /// kInvalidArgument if a field is outside its range.
    Status validate() const;
};

inline constexpr auto kRegularityFields = std::to_array<ParameterField<RegularityConfig>>({
    {FACET_FIELD(RegularityConfig, sigma_m), "m", 1e-3, 0.5,
     "Standard deviation of a landmark's distance from the plane that holds it: how flat real surfaces are."},
    {FACET_FIELD(RegularityConfig, use_gravity), "-", 0, 1, "Constrain floors to be level and walls to be upright."},
});

}  // namespace facet
