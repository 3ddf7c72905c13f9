// SPDX-License-Identifier: BSD-2-Clause
// Histograms of heights and of walls, in which the faces of a mesh vote for level and upright planes.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "estimator/values/planes.h"
#include "platform/base/fixed_vector.h"

namespace facet {

/// A place where many faces vote for the same plane n . p = d.
struct PlanePeak {
    PlaneKind kind = PlaneKind::kHorizontal;
    Eigen::Vector3d normal_W = Eigen::Vector3d::UnitZ();
    double distance_m = 0.0;
    float support_m2 = 0.0F;  ///< votes, in weighted area, within the smoothing kernel
};

/// Votes of one keyframe. Heights and distances are relative to an origin that moves with the vehicle and reach
/// +-kReach around it, so the histograms have a fixed size anywhere. The two sides of a surface are kept apart: floors
/// from ceilings, and walls by azimuth over the full turn.
///   horizontal [Rosinol19]: height of each vertex
///   vertical: azimuth x distance. Unlike in the paper a face votes for every azimuth a within its uncertainty, with
///   the distance n(a) . (centroid - origin) of a wall of this azimuth through its centroid. With a single azimuth, its
///   error would move the distance by decimetres far from the foot of the perpendicular and scatter the votes.
/// Smoothing is by a Gaussian along height and distance, as wide as the votes are uncertain. Votes beyond the reach are
/// dropped. Thread-bound. No heap. About 100 KB.
class PlaneVotes {
public:
    static constexpr double kReach = 7.68;     // m
    static constexpr int kHeightBins = 512;    // of 3 cm
    static constexpr int kAzimuthBins = 120;   // of 3 deg
    static constexpr int kDistanceBins = 192;  // of 8 cm
    static constexpr int kMaxPeaks = 32;

    PlaneVotes();
    void begin(const Eigen::Vector3d& origin_W);

    /// @param is_up    side the face is seen from
    /// @param z_W      height of one vertex (m)
    /// @param weight   (m^2)
    /// @param sigma_m  of the height
    void vote_level(bool is_up, double z_W, float weight, float sigma_m);
    /// @param normal_W     of the face, need not be level
    /// @param sigma_rad    of its azimuth
    void vote_upright(const Eigen::Vector3f& normal_W, float sigma_rad, const Eigen::Vector3d& centroid_W, float weight,
                      float sigma_m);

    /// Smooths, and finds local maxima of at least this support, strongest first (kMaxPeaks at most).
    std::span<const PlanePeak> find_peaks(float min_support_m2);

private:
    void keep(const PlanePeak& peak);
    bool may_peak(std::size_t azimuth, float least) const;
    void find_level(float least);
    void find_upright(float least);

    using Row = std::array<float, kDistanceBins>;
    static constexpr int kLanes = 8;  // rows whose votes are computed side by side
    using Lanes = Eigen::Array<float, kLanes, 1>;
    Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
    /// Of the middles of the bins, x and y; the first ones again after the last, so that kLanes begin anywhere.
    Eigen::Array<float, kAzimuthBins + kLanes, 1> direction_x_;
    Eigen::Array<float, kAzimuthBins + kLanes, 1> direction_y_;
    Lanes lane_;  ///< 0, 1, ...
    std::array<std::array<float, kHeightBins>, 2> heights_{};
    std::array<Row, kAzimuthBins> walls_{};
    std::array<bool, kAzimuthBins> may_peak_{};  ///< rows that may have a peak, and are smoothed
    float level_weight_ = 0.0F;
    float level_variance_ = 0.0F;  ///< weighted sum
    float upright_weight_ = 0.0F;
    float upright_variance_ = 0.0F;
    FixedVector<PlanePeak, kMaxPeaks> peaks_;
};

}  // namespace facet
