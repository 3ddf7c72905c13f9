// SPDX-License-Identifier: BSD-2-Clause
// A thing that moves through the scene: a textured box that crosses the view now and then.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/lab/sim/bvh.h"
#include "app/lab/sim/flight.h"
#include "app/lab/sim/scene.h"
#include "platform/base/timestamp.h"

namespace facet::sim {

/// One crossing: the box glides straight on, turning about the vertical; before and after it is nowhere.
struct Crossing {
    double begin_s = 0.0;
    double end_s = 0.0;
    Eigen::Vector3d start_W;                        ///< box centre at begin_s
    Eigen::Vector3d v_W = Eigen::Vector3d::Zero();  ///< (m/s)
    double start_yaw_rad = 0.0;
    double yaw_rate_rad_per_s = 0.0;
};

/// Where the box is around one time: p_W = R Exp(tau w e_z) p_M + p + tau v, the turn to first order.
struct MoverPose {
    Eigen::Matrix3f R_W_M;
    Eigen::Vector3f p_W;
    Eigen::Vector3f v_W;
    float yaw_rate = 0.0F;  ///< w (rad/s)
};

/// The box as a scene of its own in its frame M, lit evenly and casting no shadow on the rest. Immutable; queries are
/// reentrant and use no heap.
class Mover {
public:
    static constexpr double kSide_m = 0.75;

    Mover(const SceneDetail& detail, std::vector<Crossing> crossings);

    const std::vector<Crossing>& crossings() const { return crossings_; }
    /// Where it is; nothing while it is nowhere.
    std::optional<MoverPose> pose(double t_s) const;

    /// Replaces the radiance of those of the packet's rays that meet the box before their hit in the scene.
    /// @param taus  of the rays, from the time of the pose (s)
    /// @param packet  after the scene's Bvh::intersect; @param radiance  of its four rays, shaded in the scene
    void cover(const MoverPose& pose, const F4& taus, const RayPacket& packet, float spread, float* radiance) const;

private:
    Scene box_;
    std::vector<Crossing> crossings_;
};

/// Crossings of 3 s, one in every 6 s from `from_s` on, each when there is most room before the camera: the box glides
/// from beside the view at its beginning, 1.7 m ahead, to the other side at its end, and fills about a fifth of the
/// view on the way. Where the scene leaves no room there is none, but at least one fits if the time allows.
/// Deterministic.
/// @param T_B_C  of the left camera; z forward
std::vector<Crossing> plan_crossings(const Scene& scene, const Flight& flight, const Se3& T_B_C, double from_s,
                                     double end_s, std::uint64_t seed);

/// The crossings as JSON, for truth/mover.json. @param epoch  stamp that their seconds count from
std::string mover_json(const Mover& mover, Timestamp epoch);

}  // namespace facet::sim
