// SPDX-License-Identifier: BSD-2-Clause
// Which correction of the odometry several recognitions agree on.
#pragma once

#include <cstdint>

#include "mesh/places/yaw_pose.h"
#include "platform/base/fixed_vector.h"

namespace facet {

/// Where nothing is known of where the vehicle is, one recognition proves little: windows, doors and whole offices look
/// alike. A correction is believed if the recognitions of several stations have it in common, and no other correction
/// has half as many matches to show: twins of a place tie, until something is seen that only one of them has.
/// Thread-bound. No heap.
class CorrectionVotes {
public:
    void clear() { candidates_.clear(); }

    /// A recognition. @param station  its number: each station counts once for a correction
    /// @param T_O_G  where odometry has the view, @param T_M_G  where the recognised place has it
    void add(std::uint32_t station, const YawPose& T_O_G, const YawPose& T_M_G, int inliers);

    /// Whether a correction is believed: the one that the last recognition added to.
    bool is_settled(int stations) const;
    /// It, as T_M_O. Contract: is_settled().
    const YawPose& T_M_O() const { return candidates_[newest_].T_M_O; }

private:
    struct Candidate {
        YawPose T_M_O;
        std::uint32_t station = 0;
        int stations = 0;
        int inliers = 0;
    };
    FixedVector<Candidate, 16> candidates_;
    std::size_t newest_ = 0;
};

}  // namespace facet
