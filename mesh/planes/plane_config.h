// SPDX-License-Identifier: BSD-2-Clause
// Parameters of the plane finder.
#pragma once

#include <string_view>

#include "estimator/values/capacity.h"
#include "platform/base/parameter_field.h"
#include "platform/base/status.h"

namespace facet {

/// Units, ranges and meanings: kPlaneFields below.
struct PlaneConfig {
    /// A plane is no longer reported when it has not been found for more keyframes than this.
    static constexpr int kLeaveKeyframes = 4;
    double face_angle_deg = 4.0;
    double max_face_angle_deg = 28.0;
    double min_support_m2 = 0.2;
    double join_m = 0.08;
    double join_sigmas = 2.5;
    double stay_m = 0.12;
    double stay_sigmas = 3.5;
    double max_point_sigma_m = 0.06;
    double surface_sigma_m = 0.005;
    double max_tilt_deg = 3.0;
    bool find_slanted = true;
    int min_landmarks = 14;
    double min_area_m2 = 0.35;
    double min_extent_m = 0.12;
    double max_chi2 = 1.0;
    double max_bend_m = 0.010;
    int forget_keyframes = 100;

    /// The condition between fields that does not hold, as a sentence; empty if all hold.
    std::string_view broken_rule() const;
    /// kInvalidArgument if a field is outside its range or a condition between fields does not hold.
    Status validate() const;
};

inline constexpr auto kPlaneFields = std::to_array<ParameterField<PlaneConfig>>({
    {FACET_FIELD(PlaneConfig, face_angle_deg), "deg", 0.5, 30,
     "A face supports a plane if its normal is within this angle, plus two standard deviations, of the plane's."},
    {FACET_FIELD(PlaneConfig, max_face_angle_deg), "deg", 1, 60,
     "No face supports a plane from which its normal is turned farther than this, however uncertain it is; small "
     "faces are mostly noise."},
    {FACET_FIELD(PlaneConfig, min_support_m2), "m^2", 0.01, 100,
     "Least votes for a new plane, as the weighted area of its faces."},
    {FACET_FIELD(PlaneConfig, join_m), "m", 0.005, 0.5, "A landmark joins a plane only if its distance is below this."},
    {FACET_FIELD(PlaneConfig, join_sigmas), "-", 0.5, 10,
     "A landmark joins a plane only if its distance is below this many standard deviations."},
    {FACET_FIELD(PlaneConfig, stay_m), "m", 0.005, 1, "A landmark leaves its plane if its distance is above this."},
    {FACET_FIELD(PlaneConfig, stay_sigmas), "-", 0.5, 20,
     "A landmark leaves its plane if its distance is above this many standard deviations."},
    {FACET_FIELD(PlaneConfig, max_point_sigma_m), "m", 0.005, 1,
     "Landmarks whose standard deviation across a plane exceeds this do not join it."},
    {FACET_FIELD(PlaneConfig, surface_sigma_m), "m", 0.001, 0.1,
     "Standard deviation of points of a real surface from its plane: how flat surfaces are."},
    {FACET_FIELD(PlaneConfig, max_tilt_deg), "deg", 0.1, 20,
     "Largest angle of a floor from level and of a wall from upright."},
    {FACET_FIELD(PlaneConfig, find_slanted), "-", 0, 1,
     "Find ramps, pitched ceilings and the like as well, whose direction gravity does not give."},
    {FACET_FIELD(PlaneConfig, min_landmarks), "-", 4, kMaxPlaneLandmarks, "Least number of landmarks of a new plane."},
    {FACET_FIELD(PlaneConfig, min_area_m2), "m^2", 0.01, 100,
     "Least area covered by the faces of a new plane; of a slanted one twice as much."},
    {FACET_FIELD(PlaneConfig, min_extent_m), "m", 0.01, 10,
     "Least standard deviation of a new plane's landmarks along its shorter side."},
    {FACET_FIELD(PlaneConfig, max_chi2), "-", 0.5, 100,
     "Largest sum of a plane's squared residuals, in standard deviations, per degree of freedom; clutter is above."},
    {FACET_FIELD(PlaneConfig, max_bend_m), "m", 0.001, 1,
     "Largest root mean square of the difference between a plane and the quadratic surface that fits its points best."},
    {FACET_FIELD(PlaneConfig, forget_keyframes), "-", 1, 10000,
     "A plane no longer reported keeps its identity if it is found again within this many keyframes."},
});

}  // namespace facet
