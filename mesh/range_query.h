// SPDX-License-Identifier: BSD-2-Clause
// Ranges from the mesh for obstacle avoidance: rays, nearest points, cones, and sectors all around.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

#include "mesh/horizon_mesh.h"

namespace facet {

/// What a query found.
struct RangeHit {
    double distance_m = 0.0;                        ///< from the query's position; max_range_m if nothing was found
    Eigen::Vector3d p_W = Eigen::Vector3d::Zero();  ///< the point of the mesh (m); only if found
    FaceIndex face = HorizonMesh::kNoFace;          ///< of the mesh at update(); kNoFace: nothing within range
    bool found() const { return face != HorizonMesh::kNoFace; }
};

/// What a sweep covers. Azimuths are about W's z axis, counterclockwise; sector k spans start_rad + k width to
/// start_rad + (k + 1) width, width 2 pi / kSweepSectors.
struct SweepRequest {
    Eigen::Vector3d p_W = Eigen::Vector3d::Zero();  ///< the vehicle (m)
    double start_rad = 0.0;                         ///< azimuth where sector 0 begins
    double below_m = 0.5;                           ///< obstacles from this much below the vehicle
    double above_m = 0.5;                           ///< to this much above it count
    double max_range_m = 10.0;
};

/// A copy of the mesh's faces, at the shown positions of their vertices, laid out for queries: a pass of vector
/// instructions compares arrays of bounding spheres with the query, and only faces that may hold the answer are
/// computed exactly. Exact to rounding of float coordinates relative to the mesh's middle.
/// Thread-bound. No heap. About 1 MB.
class RangeQuery {
public:
    /// Copies the faces that were observed at least this often; filled holes always count.
    void update(const HorizonMesh& mesh, int min_observations = 1);
    int faces() const { return count_; }

    /// First face along a ray, from either side. @param direction  of any length but zero
    RangeHit cast(const Eigen::Vector3d& p_W, const Eigen::Vector3d& direction, double max_range_m) const;

    /// Nearest point of the mesh.
    RangeHit nearest(const Eigen::Vector3d& p_W, double max_range_m) const;

    /// Nearest point of the mesh within a cone. @param half_angle_rad  (0, pi/2)
    RangeHit nearest_in_direction(const Eigen::Vector3d& p_W, const Eigen::Vector3d& direction, double half_angle_rad,
                                  double max_range_m) const;

    /// Horizontal distance to the nearest point of the mesh in each sector, within the band of heights; max_range_m
    /// in sectors without one.
    void sweep(const SweepRequest& request, std::span<double, kSweepSectors> range_m);

private:
    using Corners = std::array<Eigen::Vector3f, 3>;  ///< relative to middle_
    struct Sweep;                                    ///< state of one sweep

    Eigen::Vector3d corner(std::size_t i, std::size_t k) const { return corners_[i][k].cast<double>(); }
    RangeHit found(double distance, const Eigen::Vector3d& p, std::size_t i) const;
    void bound_for_sweep(const SweepRequest& request, float start_turns);
    std::size_t order_for_sweep(double max_range_m);
    static std::size_t cut_at_height(std::array<Eigen::Vector3d, 5>& polygon, std::size_t count, double side,
                                     double limit);
    void sweep_face(std::size_t face, const Eigen::Vector3d& q, const SweepRequest& request, Sweep& sweep);

    int count_ = 0;
    Eigen::Vector3d middle_ = Eigen::Vector3d::Zero();
    alignas(32) std::array<float, kMaxMeshFaces> x_{};  ///< centres of the bounding spheres
    alignas(32) std::array<float, kMaxMeshFaces> y_{};
    alignas(32) std::array<float, kMaxMeshFaces> z_{};
    alignas(32) std::array<float, kMaxMeshFaces> radius_{};
    alignas(32) std::array<float, kMaxMeshFaces> radius_xy_{};  ///< seen from above
    alignas(32) std::array<float, kMaxMeshFaces> low_z_{};
    alignas(32) std::array<float, kMaxMeshFaces> high_z_{};
    std::array<Corners, kMaxMeshFaces> corners_;
    std::array<FaceIndex, kMaxMeshFaces> face_{};
    // Scratch of sweep(): lower bound of the distance, and the sectors that the face may touch.
    alignas(32) std::array<float, kMaxMeshFaces> bound_{};
    alignas(32) std::array<std::int32_t, kMaxMeshFaces> first_sector_{};
    alignas(32) std::array<std::int32_t, kMaxMeshFaces> last_sector_{};
    std::array<std::uint16_t, std::size_t{kMaxMeshFaces} + 1> selected_{};
    std::array<std::uint16_t, kMaxMeshFaces> order_{};
};

}  // namespace facet
