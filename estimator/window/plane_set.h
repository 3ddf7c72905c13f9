// SPDX-License-Identifier: BSD-2-Clause
// Which planes the window uses, and which landmarks lie on them.
#pragma once

#include "estimator/values/planes.h"
#include "estimator/window/regularity_config.h"
#include "estimator/window/window_cameras.h"

namespace facet {

/// Maintains WindowState::planes and Landmark::plane, between the mesh's proposals and the evidence of the window.
///   A plane enters with enough landmarks that fit it and do not lie along a line. Out of sight it stays as a variable
/// as long as the prior has information on it and no other plane needs its place: seen again, it corrects the drift
/// since; but if most of the landmarks seen then are off it, it restarts where they are. It leaves when too few
/// landmarks hold it before marginalization has used it, or when its landmarks, if free, would not lie on it; in the
/// latter case it is refused for 8 keyframes, and for twice as long each time that this happens again, after which it
/// has to pass all tests again. When a plane leaves, the prior's information on it is marginalized and its landmarks
/// are free again.
///   A landmark joins a plane whose proposal lists it if its distance is below kJoinSigmas of its own and the plane's
/// uncertainty; it leaves beyond kLeaveSigmas, and does not rejoin after the second time.
///   The heights of many landmarks above one plane count less than as many independent ones
/// (RegularityConfig::weigh_m); their number is that at the begin of the optimization.
/// Thread-bound. No heap.
class PlaneSet {
public:
    void configure(const RegularityConfig& config);
    /// The window restarts, without planes.
    void reset();

    /// Before an optimization, with the landmarks triangulated.
    void update(const PlaneProposals& proposals, WindowState& state, const WindowCameras& cameras);

    /// After an optimization: gives up what did not fit, and updates the pairs.
    void judge(WindowState& state);

private:
    /// Height of a landmark above a plane, and its variance.
    struct Height {
        double m = 0.0;
        double variance_m2 = 0.0;
    };
    bool measure(const Landmark& landmark, const Plane& plane, const WindowCameras& cameras, Height& out) const;
    enum class Fit { kOn, kOff, kUnknown };  ///< of a landmark with a plane; kUnknown: not enough is known
    Fit judge_fit(const Landmark& landmark, const Plane& plane, const WindowCameras& cameras) const;
    bool has_moved(const PlaneProposal& proposal, const Plane& plane, WindowState& state,
                   const WindowCameras& cameras) const;
    bool is_refused(PlaneId id) const;
    void refuse(PlaneId id);
    void remove(int plane, WindowState& state) const;
    bool make_room(WindowState& state) const;
    void admit(const PlaneProposal& proposal, WindowState& state, const WindowCameras& cameras);
    void assign(const PlaneProposals& proposals, WindowState& state, const WindowCameras& cameras) const;
    void weigh(WindowState& state) const;

    /// A plane that was given up.
    struct Refusal {
        PlaneId id;
        int wait = 0;  ///< keyframes, of the last time
        int left = 0;  ///< of these; 0: it may return
    };

    RegularityConfig config_;
    boost::container::static_vector<Refusal, 4 * kMaxPlanes> refused_;  ///< by last refusal
};

}  // namespace facet
