// SPDX-License-Identifier: BSD-2-Clause
// Parameters of structural regularities: planes in the window.
#pragma once

#include <cstdint>

#include "platform/base/status.h"

namespace facet {

/// The modes of [Rosinol19].
enum class RegularityMode : std::uint8_t {
    kS,    ///< no planes
    kSp,   ///< landmarks are assigned to planes, but nothing holds them there
    kSpr,  ///< planes are variables, and landmarks are held on them
};

constexpr const char* to_string(RegularityMode mode) {
    switch (mode) {
        case RegularityMode::kS: return "s";
        case RegularityMode::kSp: return "sp";
        case RegularityMode::kSpr: return "spr";
    }
    return "?";
}

/// One line a field: meaning [unit] [range] and why this default.
struct RegularityConfig {
    RegularityMode mode = RegularityMode::kS;
    double sigma_m = 0.01;         ///< how flat planes are: standard deviation of a landmark from its plane [1e-3, 0.5]
    double huber_threshold = 1.5;  ///< robust loss on whitened heights above a plane [0.5, 10]
    int min_constraints = 20;      ///< landmarks that bring a plane in [6, 256]
    int keep_constraints = 8;      ///< with fewer a plane that marginalization has not used leaves again [3, 256]
    double min_extent_m = 0.3;     ///< least spread of these, rms, along the plane's narrower side [0.01, 10]
    double join_sigmas = 2.5;      ///< a landmark nearer than this to a plane joins it [0.5, 10]
    double leave_sigmas = 3.0;     ///< one farther leaves [0.5, 20]
    double max_plane_chi2 = 1.0;   ///< mean squared height of a plane's landmarks that says it is none [1, 100]
    bool use_pairs = true;         ///< parallel and orthogonal planes as constraints
    bool use_gravity = true;       ///< level floors and upright walls as constraints
    double pair_sigma_deg = 0.15;  ///< how exact buildings are [0.01, 10]
    double pair_gate_deg = 3.0;    ///< pairs nearer than this to parallel or orthogonal are taken for it [0.1, 20]

    /// kInvalidArgument if a field is outside its range, or joining is easier than staying.
    Status validate() const;
};

}  // namespace facet
