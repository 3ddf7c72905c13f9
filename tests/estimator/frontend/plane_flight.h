// SPDX-License-Identifier: BSD-2-Clause
// A short flight before a plane, for tests of the front-end.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <vector>

#include "estimator/frontend/frontend.h"
#include "tests/estimator/frontend/synthetic.h"

namespace facet::test {

inline constexpr double kFramePeriod_s = 0.05;

inline FrontendConfig small_config() {
    FrontendConfig config;
    config.max_features = 120;
    config.corners.min_distance_px = 12.0;
    config.corners.columns = 8;
    config.corners.rows = 6;
    config.keyframe_disparity_px = 4.0;
    return config;
}

/// Images of a plane from a body that stands for `still` frames, then moves.
struct Flight {
    struct Frame {
        Timestamp stamp;
        Se3 T_W_B;
        synthetic::Image left;
        synthetic::Image right;
        StereoFrame view() const { return {stamp, left.view(), right.view()}; }
    };
    StereoRig rig = synthetic::make_rig();
    synthetic::Plane plane{Eigen::Vector3d(0.1, -0.2, 1.0).normalized(), 2.5};
    std::vector<Frame> frames;

    Flight(int count, int still) {
        const synthetic::Texture texture(0.11, 0.8, 41);
        for (int k = 0; k < count; ++k) {
            const double s = kFramePeriod_s * std::max(0, k - still);
            const Se3 T_W_B{so3_exp({0.3 * s, -0.2 * s, -1.5 + 0.4 * s}), {0.5 * s, -0.2 * s, 0.3 * s}};
            frames.push_back({Timestamp{} + Duration::from_seconds(100.0 + kFramePeriod_s * k), T_W_B,
                              synthetic::render(plane, texture, rig.left, T_W_B * rig.T_B_C0),
                              synthetic::render(plane, texture, rig.right, T_W_B * rig.T_B_C1)});
        }
    }
    Eigen::Quaterniond q_Bp_B(std::size_t k) const {
        return k == 0 ? Eigen::Quaterniond::Identity() : frames[k - 1].T_W_B.q.conjugate() * frames[k].T_W_B.q;
    }
    FrameHints hints(std::size_t k) const {
        FrameHints hints;
        hints.q_Bp_B = q_Bp_B(k);
        return hints;
    }
    /// Where points of the world should be seen in frame k, with everything shifted by `off` (normalised).
    std::vector<LandmarkPrediction> predict(const std::map<LandmarkId, Eigen::Vector3d>& points, std::size_t k,
                                            const Eigen::Vector2d& off) const {
        std::vector<LandmarkPrediction> predictions;
        for (const auto& [id, p_W] : points) {
            const Eigen::Vector3d p_C = (frames[k].T_W_B * rig.T_B_C0).inverse() * p_W;
            Eigen::Vector2d uv;
            const bool in_view = ok(rig.left.project(p_C, uv)) && rig.left.in_image(uv, 0.0);
            predictions.push_back({id, in_view, p_C.hnormalized() + off, 1.0 / p_C.z()});
        }
        return predictions;
    }
};

inline const Flight& flight() {
    static const Flight instance(16, 6);
    return instance;
}

}  // namespace facet::test
