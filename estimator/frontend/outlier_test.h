// SPDX-License-Identifier: BSD-2-Clause
// Geometric outlier tests with known rotation: 2-point epipolar and 1-point stereo.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "estimator/frontend/frontend_config.h"
#include "platform/base/status.h"

namespace facet {

/// One track seen in the last keyframe and now.
struct MonoPair {
    Eigen::Vector3d rotated = Eigen::Vector3d::UnitZ();  ///< bearing then, rotated into the present camera
    Eigen::Vector2d xy = Eigen::Vector2d::Zero();        ///< normalised, now
};

/// One track matched in stereo in the last keyframe and now.
struct StereoPair {
    Eigen::Vector3d rotated = Eigen::Vector3d::UnitZ();  ///< 3D point then, rotated into the present camera (m)
    Eigen::Vector3d now = Eigen::Vector3d::UnitZ();      ///< 3D point now (m)
};

/// Both tests take the rotation as known from the gyroscope, so that two (one) correspondences fix a hypothesis. They
/// draw a fixed number of hypotheses from a generator that is seeded anew in every call: equal inputs give equal
/// verdicts. When the data cannot tell, nothing is rejected. Heap: in configure() only. Thread-bound.
class OutlierTest {
public:
    /// @param focal_px    turns normalised distances into pixels
    /// @param baseline_m  of the stereo pair, for the depth's uncertainty
    void configure(const FrontendConfig& config, double focal_px, double baseline_m);

    /// Epipolar test: n_i = f_i' x f_i is normal to the translation t of the camera. t is drawn from pairs
    /// (t = n_i x n_j), scored by the truncated distance to the epipolar lines; the best one is refined together with a
    /// small correction of the rotation, which takes up what the gyroscope got wrong.
    /// @param inlier  one flag a pair, set
    /// @return kDegenerate if there are fewer than 8 pairs, too little parallax, or no model that at least half of the
    ///         pairs agree with: every flag is then 1.
    Status mono(std::span<const MonoPair> pairs, std::span<std::uint8_t> inlier);

    /// Translation test: every pair gives t_i = now - rotated, with a covariance that grows with depth; t is drawn from
    /// single pairs, scored by Mahalanobis distance, and refined by a weighted mean.
    /// @return kDegenerate with fewer than 4 pairs, or if fewer than half agree: every flag is then 1.
    Status stereo(std::span<const StereoPair> pairs, std::span<std::uint8_t> inlier);

private:
    std::uint32_t draw(std::uint32_t below);
    double score_mono(std::span<const MonoPair> pairs, const Eigen::Vector3d& t, const Eigen::Vector3d& theta) const;
    void refine_mono(std::span<const MonoPair> pairs, Eigen::Vector3d& t, Eigen::Vector3d& theta) const;
    Eigen::Matrix3d covariance(const Eigen::Vector3d& point) const;

    FrontendConfig config_;
    double focal_px_ = 1.0;
    double baseline_m_ = 1.0;
    std::uint64_t random_ = 0;
    std::vector<Eigen::Vector3d> normals_;
    std::vector<Eigen::Matrix3d> covariances_;
    std::vector<double> parallax_;
};

}  // namespace facet
