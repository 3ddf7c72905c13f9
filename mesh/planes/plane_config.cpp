// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/planes/plane_config.h"

#include "platform/base/range_check.h"

namespace facet {

Status PlaneConfig::validate() const {
    const bool faces_ok = in_range(face_angle_deg, 0.5, 30.0) && in_range(max_face_angle_deg, 1.0, 60.0) &&
                          in_range(max_face_area_m2, 0.01, 10.0) && in_range(min_support_m2, 0.01, 100.0);
    const bool landmarks_ok = in_range(search_gate_m, 0.02, 1.0) && in_range(join_m, 0.005, 0.5) &&
                              in_range(join_sigmas, 0.5, 10.0) && in_range(stay_m, 0.005, 1.0) &&
                              in_range(stay_sigmas, 0.5, 20.0) && in_range(max_point_sigma_m, 0.005, 1.0) &&
                              in_range(surface_sigma_m, 0.001, 0.1) && stay_m >= join_m && stay_sigmas >= join_sigmas;
    const bool guards_ok = in_range(max_tilt_deg, 0.1, 20.0) && in_range(min_landmarks, 4, 256) &&
                           in_range(min_area_m2, 0.01, 100.0) && in_range(min_extent_m, 0.01, 10.0) &&
                           in_range(max_chi2, 0.5, 100.0) && in_range(max_bend_m, 0.001, 1.0) &&
                           in_range(max_roughness_m, 0.001, 1.0) && in_range(min_coherence, 0.0, 1.0);
    const bool identity_ok = in_range(same_angle_deg, 0.1, 30.0) && in_range(same_distance_m, 0.005, 1.0) &&
                             in_range(confirm_keyframes, 1, 20) && in_range(leave_keyframes, 1, 100) &&
                             in_range(forget_keyframes, 1, 10000);
    return faces_ok && landmarks_ok && guards_ok && identity_ok ? Status::kOk : Status::kInvalidArgument;
}

}  // namespace facet
