// SPDX-License-Identifier: BSD-2-Clause
// What the faces that no plane explains have to say.
#include <algorithm>
#include <cmath>

#include "mesh/planes/plane_evidence.h"
#include "platform/base/angle.h"

namespace facet {
namespace {

// Area beyond which a face gains no more votes for a plane: however large, it stands on three points (m^2).
constexpr double kMaxFaceArea_m2 = 0.15;
constexpr float kVoteTilt = 0.10F;  // rad: faces known better than this have their full vote

}  // namespace

/// Whether all its corners are on planes, or it shows no surface of its own.
bool PlaneEvidence::is_explained(const Face& face) const {
    return face.is_fill ||
           (state_[face.point[0]].owner != 0 && state_[face.point[1]].owner != 0 && state_[face.point[2]].owner != 0);
}

/// Faces whose normal says little do not vote.
void PlaneEvidence::vote(SlantVotes& votes) const {
    const auto widest = static_cast<float>(kRadPerDeg * PlaneLimits::kMaxFaceAngle_deg);
    const auto most = static_cast<float>(kMaxFaceArea_m2);
    for (const Face& face : faces_) {
        if (!is_explained(face) && 2.0F * face.tilt_sigma < widest) {
            votes.vote(face.normal_W, face.centroid,
                       std::min(face.area, most) * std::min(1.0F, kVoteTilt / face.tilt_sigma));
        }
    }
}

/// Weight of a vote: area up to a limit, times the likelihood that a plane of this kind gives such a normal, times a
/// factor for how well the normal is known.
void PlaneEvidence::vote(PlaneVotes& votes) const {
    const auto base = static_cast<float>(kRadPerDeg * PlaneLimits::kFaceAngle_deg);
    const auto widest = static_cast<float>(kRadPerDeg * PlaneLimits::kMaxFaceAngle_deg);
    const auto most = static_cast<float>(kMaxFaceArea_m2);
    for (const Face& face : faces_) {
        if (is_explained(face)) {
            continue;
        }
        const float z = face.normal_W.z();
        const float level = face.normal_W.head<2>().norm();  // sine of the angle to the vertical
        const bool is_level = level < std::abs(z);
        const float sine = std::min(1.0F, is_level ? level : std::abs(z));
        const float limit = std::min(widest, base + 2.0F * face.tilt_sigma);
        if (sine > limit) {
            continue;  // an angle is larger than its sine
        }
        const float angle = std::asin(sine);
        if (angle > limit) {
            continue;
        }
        const float sigma = std::sqrt(0.25F * base * base + face.tilt_sigma * face.tilt_sigma);
        const float off = angle / sigma;
        const float weight =
            std::min(face.area, most) * std::exp(-0.5F * off * off) * std::min(1.0F, kVoteTilt / face.tilt_sigma);
        if (is_level) {
            for (const std::uint16_t p : face.point) {
                votes.vote_level(z > 0.0F, points_[p].p_W.z(), weight / 3.0F, face.sigma);
            }
        } else {
            votes.vote_upright(face.normal_W, std::min(sigma, widest), origin_ + face.centroid.cast<double>(), weight,
                               face.sigma);
        }
    }
}

}  // namespace facet
