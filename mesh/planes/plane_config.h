// SPDX-License-Identifier: BSD-2-Clause
// Parameters of the plane finder, and the limits by which it judges.
#pragma once

#include "platform/base/parameter_field.h"
#include "platform/base/status.h"

namespace facet {

/// Units, ranges and meanings: kPlaneFields below.
struct PlaneConfig {
    double surface_sigma_m = 0.005;
    bool find_slanted = true;
    double min_area_m2 = 0.35;

    /// kInvalidArgument if a field is outside its range.
    Status validate() const;
};

inline constexpr auto kPlaneFields = std::to_array<ParameterField<PlaneConfig>>({
    {FACET_FIELD(PlaneConfig, surface_sigma_m), "m", 0.001, 0.1,
     "Standard deviation of points of a real surface from its plane: how flat surfaces are."},
    {FACET_FIELD(PlaneConfig, find_slanted), "-", 0, 1,
     "Find ramps, pitched ceilings and the like as well, whose direction gravity does not give."},
    {FACET_FIELD(PlaneConfig, min_area_m2), "m^2", 0.01, 100,
     "Least area covered by the faces of a new plane; of a slanted one twice as much."},
});

/// Limits that several steps of the finder share.
struct PlaneLimits {
    /// A face supports a plane if its normal is within this angle, plus two standard deviations, of the plane's...
    static constexpr double kFaceAngle_deg = 4.0;
    /// ...but never beyond this one, however uncertain the face is: small faces are mostly noise.
    static constexpr double kMaxFaceAngle_deg = 28.0;
    /// A landmark whose standard deviation across the plane is larger does not join it.
    static constexpr double kMaxPointSigma_m = 0.06;
    /// A landmark joins a plane below this distance, and below this many standard deviations...
    static constexpr double kJoin_m = 0.08;
    static constexpr double kJoinSigmas = 2.5;
    /// ...and leaves it beyond these, so that noise does not move it to and fro.
    static constexpr double kStay_m = 0.12;
    static constexpr double kStaySigmas = 3.5;
    /// Largest angle of a floor from level and of a wall from upright.
    static constexpr double kMaxTilt_deg = 3.0;
    /// A plane's squared residuals in standard deviations, per degree of freedom; clutter is above.
    static constexpr double kMaxChi2 = 1.0;
    /// Root mean square of the difference between a plane and the quadratic surface that fits its points best.
    static constexpr double kMaxBend_m = 0.010;
    /// A plane is no longer reported when it has not been found for more keyframes than this...
    static constexpr int kLeaveKeyframes = 4;
    /// ...and keeps its identity if it is found again within this many.
    static constexpr int kForgetKeyframes = 100;
};

}  // namespace facet
