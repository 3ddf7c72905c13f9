// SPDX-License-Identifier: BSD-2-Clause
// The pose of a view in a place, from points that both have seen.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>

#include "mesh/places/place.h"
#include "mesh/places/yaw_pose.h"

namespace facet {

/// Fits the pose of a view G in a place K to points of K that the view has sighted. The errors are those of direction
/// and, where the view knows the depth itself, of inverse depth, in the present camera. They are whitened by pixel
/// noise on both sides and by the points' own depth sigmas, and stand under a Cauchy loss. Four more unknowns have
/// priors: the tilt of one view against the other, as each knows gravity for itself only, and what the calibration
/// does to the depths of each view, an offset of all its inverse depths (PlaceView::shared_rho_sigma). Reentrant. No
/// heap.
class SightingFit {
public:
    static constexpr double kAll = std::numeric_limits<double>::infinity();

    struct State {
        YawPose T_K_G;
        Eigen::Vector2d tilt = Eigen::Vector2d::Zero();  ///< about x and y of G, of the place in the view (rad)
        double known_offset = 0.0;                       ///< to be added to the place's inverse depths (1/m)
        double seen_offset = 0.0;                        ///< to the view's
    };
    /// What the sightings say of a state.
    struct Result {
        YawPose::Covariance covariance = YawPose::Covariance::Zero();  ///< of the pose
        int inliers = 0;                                               ///< with an error that 99 % are below
        int measurements = 0;                                          ///< of the inliers: two each, three with a depth
        double chi2 = 0.0;                                             ///< of the inliers
    };

    /// Both views must outlive it. @param pixel  standard deviation of a direction on either side
    SightingFit(const PlaceView& seen, const PlaceView& known, double pixel);

    /// Where the view has its own point: at [x y 1] in the camera.
    Eigen::Vector2d direction_of(std::size_t seen) const { return point_C(seen).hnormalized(); }
    /// Point `known` of the place is seen at a direction.
    /// @param seen  point of the view that lies there, with its depth
    void add(std::size_t known, const Eigen::Vector2d& xy, std::optional<std::size_t> seen);

    std::size_t size() const { return sightings_.size(); }
    /// Number of sightings within a gate. @param looseness  factor on the squared error that 99 % are below
    int count_inliers(const State& state, double looseness) const;
    /// A Gauss-Newton step on the sightings within a gate. @return what they said before it
    Result step(double looseness, State& state) const;

private:
    struct Sighting {
        Eigen::Vector3d p_K;
        double depth_K = 0.0;  ///< in the place's camera (m)
        double depth_sigma = 0.0;
        Eigen::Vector2d xy;
        double rho = 0.0;        ///< 1 / depth in the present camera (1/m)
        double rho_sigma = 0.0;  ///< infinite: the view does not know the depth

        bool has_depth() const { return rho_sigma < std::numeric_limits<double>::infinity(); }
        /// The squared error that 99 % are below.
        double gate() const;
    };
    static constexpr int kUnknowns = 8;
    using Jacobian = Eigen::Matrix<double, 3, kUnknowns>;

    Eigen::Vector3d point_C(std::size_t seen) const { return R_C_G_ * seen_.points[seen].p_G.cast<double>(); }
    /// The error and the inverse of its covariance. @param jacobian  by the state; nullptr to skip
    /// @return false if the point is not in front of the camera
    bool evaluate(const Sighting& s, const State& state, Eigen::Vector3d& error, Eigen::Matrix3d& information,
                  Jacobian* jacobian) const;

    const PlaceView& seen_;
    const PlaceView& known_;
    Eigen::Matrix3d R_C_G_;
    double pixel_;
    FixedVector<Sighting, kMaxPlacePoints> sightings_;
};

}  // namespace facet
