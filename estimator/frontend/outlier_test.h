// SPDX-License-Identifier: BSD-2-Clause
// Geometric outlier tests with known rotation: 2-point epipolar and 1-point stereo.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

#include "estimator/frontend/frontend_config.h"
#include "estimator/geometry/stereo_rig.h"
#include "estimator/values/capacity.h"
#include "platform/base/status.h"

namespace facet {

/// One track seen in the last keyframe and now.
struct MonoPair {
    Eigen::Vector3d rotated = Eigen::Vector3d::UnitZ();  ///< bearing then, rotated into the present camera
    Eigen::Vector2d xy = Eigen::Vector2d::Zero();        ///< normalised, now
};

/// One track matched in stereo in the last keyframe and now.
struct StereoPair {
    Eigen::Vector3d then = Eigen::Vector3d::UnitZ();  ///< 3D point in the left camera then (m)
    Eigen::Vector3d now = Eigen::Vector3d::UnitZ();   ///< in the left camera now (m)
};

/// Both tests take the rotation as known from the gyroscope, so that two (one) correspondences define a hypothesis.
/// They draw a fixed number of hypotheses from a generator that is seeded again in every call: equal inputs give equal
/// verdicts. When the data are not conclusive, nothing is rejected. All limits are in pixels of the image: distances in
/// normalised coordinates are converted by the lens's derivative where the point is seen. Hypotheses are scored on
/// arrays of single components, which the compiler vectorizes. No heap. Thread-bound.
class OutlierTest {
public:
    void configure(const FrontendConfig& config, const StereoRig& rig);

    /// Epipolar test: n_i = f_i' x f_i is normal to the translation t of the camera. t is drawn from pairs
    /// (t = n_i x n_j) and scored by the truncated distance to the epipolar lines; the best one is refined together
    /// with a small correction of the rotation, which absorbs the gyroscope's error.
    /// @param inlier  one flag per pair, set
    /// @return kDegenerate if there are fewer than 8 pairs, too little parallax, or no model that at least half of the
    ///         pairs agree with: every flag is then 1.
    Status mono(std::span<const MonoPair> pairs, std::span<std::uint8_t> inlier);

    /// Translation test: every pair gives t_i = now - R then, with a covariance that grows with distance; t is drawn
    /// from single pairs, scored by Mahalanobis distance, and refined by a weighted mean.
    /// @param R  turns the left camera's coordinates then into those now
    /// @return kDegenerate with fewer than 4 pairs, or if fewer than half agree: every flag is then 1.
    Status stereo(std::span<const StereoPair> pairs, const Eigen::Matrix3d& R, std::span<std::uint8_t> inlier);

private:
    std::uint32_t draw(std::uint32_t below);
    /// Fills normals_, parallax_ and the lens's derivatives.
    void prepare_mono(std::span<const MonoPair> pairs);
    /// Fills rays_ with the pairs, their bearings turned by a small rotation.
    void load_mono(std::span<const MonoPair> pairs, const Eigen::Vector3d& theta);
    double score_mono(const Eigen::Vector3d& t) const;
    void refine_mono(std::span<const MonoPair> pairs, Eigen::Vector3d& t, Eigen::Vector3d& theta) const;
    /// Best of the drawn hypotheses; false if no hypothesis could be drawn.
    bool draw_direction(std::size_t pairs, Eigen::Vector3d& t, double& score);
    Eigen::Matrix3d covariance(const Eigen::Vector3d& point) const;
    void load_stereo(std::span<const StereoPair> pairs, const Eigen::Matrix3d& R);
    /// Fills distances_: squared Mahalanobis distance of each pair's translation from t.
    void measure_stereo(std::size_t pairs, const Eigen::Vector3d& t, const Eigen::Matrix3d& covariance);
    std::size_t draw_translation(std::size_t pairs);

    /// Bearings f then, points x now and d_xy_d_uv there, as one array each; padded with pairs that agree with
    /// everything.
    struct Rays {
        std::array<float, kMaxFeatures> fx, fy, fz, x, y, xu, xv, yu, yv;
    };
    /// Translations and the upper triangles of their covariances, likewise.
    struct Translations {
        std::array<double, kMaxFeatures> x, y, z, xx, xy, xz, yy, yz, zz;
    };

    FrontendConfig config_;
    StereoRig rig_;
    Se3 T_C1_C0_;
    std::uint64_t random_ = 0;
    std::size_t rays_used_ = 0;  ///< a multiple of the vector width
    Rays rays_{};
    Translations translations_{};
    std::array<double, kMaxFeatures> distances_{};
    std::array<Eigen::Vector3d, kMaxFeatures> normals_;
    std::array<Eigen::Matrix3d, kMaxFeatures> covariances_;
    std::array<double, kMaxFeatures> parallax_{};
    std::array<Eigen::Matrix2d, kMaxFeatures> d_xy_d_uv_;  ///< of the left lens where each pair is seen now
};

}  // namespace facet
