// SPDX-License-Identifier: BSD-2-Clause
// What truly is around the vehicle at one instant: the scene, and the box that may move through it.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/lab/eval/trajectory.h"
#include "app/lab/eval/triangle_tree.h"

namespace facet {

/// The box of truth/mover.json (facet sim --mover), in the true world. Immutable, reentrant.
class MoverTruth {
public:
    /// One crossing: straight and even, turning about the vertical.
    struct Crossing {
        Timestamp begin;
        Timestamp end;
        Eigen::Vector3d start_W = Eigen::Vector3d::Zero();  ///< centre at `begin` (m)
        Eigen::Vector3d v_W = Eigen::Vector3d::Zero();      ///< (m/s)
        double start_yaw_rad = 0.0;
        double yaw_rate_rad_per_s = 0.0;
    };

    MoverTruth(double side_m, std::vector<Crossing> crossings) : side_m_(side_m), crossings_(std::move(crossings)) {}
    /// Nothing if there is no such file; throws InputError if it is damaged.
    static std::optional<MoverTruth> load(const std::string& path);

    double side_m() const { return side_m_; }
    /// Where the box is, centre and axes; nothing while it is nowhere.
    std::optional<Se3> pose(Timestamp stamp) const;

private:
    double side_m_;
    std::vector<Crossing> crossings_;
};

/// Questions to the true world. Heap in the constructor only; queries are reentrant.
class ObstacleTruth {
public:
    /// The scene must outlive this.
    ObstacleTruth(const TriangleSoup& scene, std::optional<MoverTruth> mover);
    ObstacleTruth(const ObstacleTruth&) = delete;  // the trees refer to their triangles
    ObstacleTruth& operator=(const ObstacleTruth&) = delete;

    /// Where a ray first meets a surface, the limit if it meets none. @param direction  unit
    double cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double limit_m, Timestamp stamp) const;
    /// From a point to the nearest surface, the limit if none is nearer.
    double distance(const Eigen::Vector3d& p, double limit_m, Timestamp stamp) const;
    /// Evenly spread points of all surfaces, kSamples_per_m2 of them on a square metre. Heap.
    std::vector<Eigen::Vector3d> samples(Timestamp stamp) const;

    static constexpr double kSamples_per_m2 = 200.0;

private:
    TriangleTree tree_;
    std::vector<Eigen::Vector3d> scene_samples_;
    std::optional<MoverTruth> mover_;
    TriangleSoup box_;  ///< in the mover's frame; empty without one
    TriangleTree box_tree_;
    std::vector<Eigen::Vector3d> box_samples_;
};

/// T_true_est at a stamp, from a pair within a millisecond of it; nothing if there is none.
/// @param pairs  by increasing stamp
std::optional<Se3> alignment_at(const std::vector<PosePair>& pairs, Timestamp stamp);

}  // namespace facet
