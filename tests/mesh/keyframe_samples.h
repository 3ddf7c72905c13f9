// SPDX-License-Identifier: BSD-2-Clause
// Made-up keyframes for tests of the mesher: a camera that looks along W's x axis at landmarks.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "mesh/mesher.h"
#include "tests/support/ideal_camera.h"

namespace facet::test {

inline const CameraModel& mesh_camera() {
    static const CameraModel camera = ideal_camera(752, 480, 450.0);
    return camera;
}

/// An endless wall, 3 m away, with boxes on it, along which the camera flies in y; a window of ten keyframes, one a
/// second. Landmarks are tracked while they are in sight, most of them with gaps, as real tracks have them.
class WallFlight {
public:
    static constexpr int kWindow = 10;
    static constexpr std::int64_t kSecond = 1'000'000'000LL;

    /// View of keyframe `k` at stamp k + 100 s. @param first  no landmark was seen before this keyframe
    std::unique_ptr<KeyframeView> view(int k, int first = 0) const {
        auto view = std::make_unique<KeyframeView>();
        const int oldest = std::max(first, k - kWindow + 1);
        view->number = static_cast<std::uint32_t>(k) + 1;
        view->stamp = {(100 + k) * kSecond};
        view->oldest_stamp = {(100 + oldest) * kSecond};
        view->T_W_C0 = pose(k);
        const int begin = column_at(k - kWindow) - kColumns;
        for (int column = begin; column < column_at(k) + kColumns; ++column) {
            for (int row = 0; row < kRows; ++row) {
                add(column, row, k, oldest, *view);
            }
        }
        return view;
    }

private:
    static constexpr int kRows = 14;
    static constexpr int kColumns = 20;
    static constexpr int kOffset = 1000;  ///< ids are not negative
    static constexpr double kStep = 0.22;

    static Se3 pose(int k) { return looking_along_x({0.0, 0.15 * k, 0.0}); }
    static int column_at(int k) { return static_cast<int>(0.15 * k / kStep); }
    static double noise(std::uint32_t id, std::uint32_t salt) {
        std::minstd_rand random(id * 7919U + salt * 104729U + 1U);
        random.discard(3);
        return std::uniform_real_distribution<double>(-1.0, 1.0)(random);
    }
    static bool is_in_sight(const Eigen::Vector3d& p_W, int k, Eigen::Vector3d& p_C, Eigen::Vector2d& uv) {
        p_C = pose(k).inverse() * p_W;
        return ok(mesh_camera().project(p_C, uv)) && mesh_camera().in_image(uv, 10.0);
    }

    static void add(int column, int row, int k, int oldest, KeyframeView& view) {
        const auto id = static_cast<std::uint32_t>((column + kOffset) * kRows + row);
        const double y = kStep * (column + 0.3 * noise(id, 1));
        const double z = kStep * (row - 0.5 * kRows + 0.3 * noise(id, 2));
        const bool is_box = ((column + kOffset) / 6) % 3 == 0 && row > 3 && row < 9;
        LandmarkSnapshot s;
        s.id = {id};
        s.p_W = {(is_box ? 2.6 : 3.0) + 0.003 * noise(id, 3), y, z};
        int last = -1;
        Eigen::Vector3d p_C;
        Eigen::Vector2d uv;
        for (int j = oldest; j <= k; ++j) {
            if (is_in_sight(s.p_W, j, p_C, uv) && noise(id, 10U + static_cast<std::uint32_t>(j)) < 0.4) {
                s.first_stamp = s.keyframes == 0 ? Timestamp{(100 + j) * kSecond} : s.first_stamp;
                ++s.keyframes;
                last = j;
            }
        }
        if (s.keyframes == 0 || view.landmarks.full()) {
            return;
        }
        is_in_sight(s.p_W, k, p_C, uv);
        s.covariance_W = 1e-6F * Eigen::Matrix3f::Identity();
        s.chi2 = 1.0F;
        s.depth_m = static_cast<float>(p_C.z());
        s.depth_sigma_m = 1e-3F;
        s.stereo = s.keyframes;
        s.unseen_keyframes = k - last;
        s.is_tracked = last == k;
        s.left_xy = p_C.head<2>() / p_C.z();
        s.left_px = uv.cast<float>();
        view.landmarks.push_back(s);
    }
};

}  // namespace facet::test
