// SPDX-License-Identifier: BSD-2-Clause
// A sphere of directions, in which the faces of a mesh vote for planes that are neither level nor upright.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "estimator/values/planes.h"
#include "mesh/capacity.h"
#include "mesh/planes/plane_votes.h"
#include "platform/base/fixed_vector.h"

namespace facet {

/// Votes of one keyframe for ramps, pitched ceilings and the like. Gravity does not give their direction, as it does
/// for PlaneVotes, so that three numbers would have to be voted for at once; they are found one after the other:
///   direction: each face votes for the directions within kReach_rad of its normal
///   distance: of the faces around the strongest direction, those within kWindow_m along their mean normal that weigh
///     most
/// The faces of a peak are taken out before the next one is sought. The two sides of a surface are kept apart.
/// Directions are the cells of a cube around the origin: a face is counted in one of them, and cells share what they
/// have with those near them. Thread-bound. No heap. Time is bounded by the number of faces. About 700 KB.
class SlantVotes {
public:
    static constexpr double kReach_rad = 0.35;  // of a vote: normals of small faces are off by 5 to 10 degrees
    static constexpr float kWindow_m = 0.16F;   // what faces of one plane differ by
    static constexpr int kMaxPeaks = 4;

    SlantVotes();
    /// @param origin_W      that the centroids of faces are given from
    /// @param max_tilt_rad  nearer to level or upright than this nothing is a peak
    void begin(const Eigen::Vector3d& origin_W, double max_tilt_rad);

    /// @param normal_W     of the face, to the side it is seen from
    /// @param from_origin  of its centroid (m)
    /// @param weight       (m^2)
    void vote(const Eigen::Vector3f& normal_W, const Eigen::Vector3f& from_origin, float weight);

    /// Planes of at least this support, by the strength of their direction (kMaxPeaks at most).
    std::span<const PlanePeak> find_peaks(float min_support_m2);

private:
    static constexpr int kSide = 10;  // cells along a side of the cube: 9 deg
    static constexpr std::size_t kCells = 6 * kSide * kSide;
    static constexpr std::size_t kMaxNear = 64;  // cells within reach of one, at most: at the cube's corners
    static constexpr int kMaxRounds = 6;
    struct Voter {
        Eigen::Vector3f normal_W = Eigen::Vector3f::Zero();
        Eigen::Vector3f from_origin = Eigen::Vector3f::Zero();
        float weight = 0.0F;  ///< 0: taken out
        std::uint16_t cell = 0;
    };
    struct Near {  ///< a face around the direction being examined
        float distance_m = 0.0F;
        float weight = 0.0F;
        std::size_t voter = 0;
    };
    struct Share {  ///< of what a cell has, for a cell near it
        std::uint16_t cell = 0;
        float share = 0.0F;
    };
    static std::uint16_t cell_of(const Eigen::Vector3f& direction);
    void count(const Voter& voter, float sign);
    Eigen::Vector3f mean_normal(const Eigen::Vector3f& around) const;
    PlanePeak take_strongest(const Eigen::Vector3f& normal_W);
    bool is_slanted(const Eigen::Vector3f& normal_W) const;

    Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
    float least_sine_ = 0.0F;                        ///< of the angle to level and to upright
    std::array<Eigen::Vector3f, kCells> direction_;  ///< of the cells' middles
    std::array<FixedVector<Share, kMaxNear>, kCells> near_cells_;
    std::array<Eigen::Vector3f, kCells> normals_;  ///< weighted sum of those in a cell
    std::array<float, kCells> votes_{};
    FixedVector<Voter, kMaxMeshFaces> voters_;
    FixedVector<Near, kMaxMeshFaces> near_;  ///< scratch
    FixedVector<PlanePeak, kMaxPeaks> peaks_;
};

}  // namespace facet
