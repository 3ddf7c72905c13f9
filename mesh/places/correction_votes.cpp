// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/places/correction_votes.h"

#include <algorithm>
#include <cmath>

namespace facet {
namespace {

/// Recognitions of one correction differ by centimetres, and by what odometry drifts between them.
constexpr double kSamePlace_m = 0.25;
constexpr double kSameYaw_rad = 0.05;
constexpr int kAhead = 2;  ///< times the matches of any other

}  // namespace

void CorrectionVotes::add(std::uint32_t station, const YawPose& T_O_G, const YawPose& T_M_G, int inliers) {
    const YawPose T_M_O = T_M_G * T_O_G.inverse();
    const auto agrees = [&](const Candidate& c) {
        const YawPose::Tangent d = (c.T_M_O * T_O_G).box_minus_to(T_M_G);
        return std::abs(d[0]) < kSameYaw_rad && d.tail<3>().norm() < kSamePlace_m;
    };
    auto* found = std::ranges::find_if(candidates_, agrees);
    if (found == candidates_.end()) {
        if (candidates_.full()) {
            const auto* weakest = std::ranges::min_element(candidates_, {}, &Candidate::inliers);
            candidates_.erase_at(static_cast<std::size_t>(weakest - candidates_.begin()));
        }
        found = &candidates_.push_back({T_M_O, station, 0, 0});
    }
    if (found->stations == 0 || found->station != station) {
        ++found->stations;
        found->inliers += inliers;
    }
    found->T_M_O = T_M_O;
    found->station = station;
    newest_ = static_cast<std::size_t>(found - candidates_.begin());
}

bool CorrectionVotes::is_settled(int stations) const {
    if (newest_ >= candidates_.size() || candidates_[newest_].stations < stations) {
        return false;
    }
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
        if (i != newest_ && kAhead * candidates_[i].inliers > candidates_[newest_].inliers) {
            return false;
        }
    }
    return true;
}

}  // namespace facet
