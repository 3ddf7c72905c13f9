// SPDX-License-Identifier: BSD-2-Clause
// A room with patterned walls, seen by a camera that flies through it, and by an odometry that drifts.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <deque>
#include <limits>
#include <memory>
#include <random>
#include <vector>

#include "estimator/values/keyframe_view.h"
#include "mesh/places/yaw_pose.h"
#include "platform/base/image_view.h"
#include "tests/mesh/depth/stereo_scene.h"

namespace facet::test {

/// Walls of a box, each with a pattern of its own, and points on them.
class TexturedRoom {
public:
    /// @param seed  of the patterns and points
    explicit TexturedRoom(std::uint32_t seed = 1) : seed_(seed) {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> place(-1.0, 1.0);
        for (int i = 0; i < 2400; ++i) {
            Eigen::Vector3d p = half_.cwiseProduct(Eigen::Vector3d(place(random), place(random), place(random)));
            const int axis = i % 5 < 4 ? i % 2 : 2;
            p[axis] = std::copysign(half_[axis], p[axis]);
            points_.push_back(p);
        }
    }

    const std::vector<Eigen::Vector3d>& points() const { return points_; }
    const CameraModel& camera() const { return camera_; }

    SceneImage draw(const Se3& T_W_C) const {
        const Eigen::Matrix3d r = T_W_C.R();
        SceneImage image;
        image.pixels.reserve(static_cast<std::size_t>(kSceneWidth) * kSceneHeight);
        for (int v = 0; v < kSceneHeight; ++v) {
            for (int u = 0; u < kSceneWidth; ++u) {
                Eigen::Vector2d xy;
                static_cast<void>(camera().unproject({static_cast<double>(u), static_cast<double>(v)}, xy));
                image.pixels.push_back(grey(T_W_C.p, r * xy.homogeneous()));
            }
        }
        return image;
    }

private:
    std::uint8_t grey(const Eigen::Vector3d& from, const Eigen::Vector3d& ray) const {
        double nearest = std::numeric_limits<double>::infinity();
        int wall = 0;
        for (int axis = 0; axis < 3; ++axis) {
            if (ray[axis] != 0.0) {
                const double t = (std::copysign(half_[axis], ray[axis]) - from[axis]) / ray[axis];
                if (t < nearest) {
                    nearest = t;
                    wall = 2 * axis + (ray[axis] > 0.0 ? 1 : 0);
                }
            }
        }
        const Eigen::Vector3d p = from + nearest * ray;
        const int axis = wall / 2;
        const double shift = 100.0 * wall + 1000.0 * seed_;
        const Eigen::Vector3d at(p[(axis + 1) % 3] + shift, p[(axis + 2) % 3], 0.0);
        return static_cast<std::uint8_t>(std::lround(0.6 * noise_grey(at, 0.25) + 0.4 * noise_grey(at, 0.07)));
    }

    CameraModel camera_ = scene_rig().left;
    std::uint32_t seed_;
    Eigen::Vector3d half_{4.0, 5.0, 1.6};  ///< of the box's sides (m)
    std::vector<Eigen::Vector3d> points_;
};

/// A camera that looks along a yaw (0: along x) and level, as in W.
inline Se3 looking(const Eigen::Vector3d& p_W, double yaw) {
    Eigen::Matrix3d r;
    r.col(2) = Eigen::Vector3d(std::cos(yaw), std::sin(yaw), 0.0);
    r.col(1) = -Eigen::Vector3d::UnitZ();
    r.col(0) = r.col(1).cross(r.col(2));
    return {Eigen::Quaterniond(r), p_W};
}

/// Keyframes of a flight, two a second, in a window of five seconds. What odometry says of a pose is T_O_W of it.
class RoomFlight {
public:
    static constexpr std::int64_t kStep_ns = 500'000'000;
    static constexpr std::size_t kWindow = 10;

    explicit RoomFlight(const TexturedRoom& room) : room_(room) {}

    YawPose T_O_W;  ///< the drift so far
    KeyframeView::HeadingAndPlace covariance = 1e-8 * Eigen::Matrix4d::Identity();

    /// The next keyframe. The view and the image last until the one after it.
    const KeyframeView& fly_to(const Se3& T_W_C) {
        image_ = room_.draw(T_W_C);
        ++number_;
        KeyframeView& view = *view_;
        view.clear();
        view.number = number_;
        view.stamp = {static_cast<std::int64_t>(number_) * kStep_ns};
        view.T_W_C0 = T_O_W * T_W_C;
        view.heading_and_place = covariance;
        window_.push_back({view.stamp, view.T_W_C0});
        if (window_.size() > kWindow) {
            window_.pop_front();
        }
        view.oldest_stamp = window_.front().stamp;
        for (const KeyframePose& pose : window_) {
            view.keyframes.push_back(pose);
        }
        add_points(T_W_C);
        return view;
    }
    ImageView image() const { return image_.view(); }

private:
    void add_points(const Se3& T_W_C) {
        const Se3 T_C_W = T_W_C.inverse();
        for (std::size_t i = 0; i < room_.points().size() && !view_->landmarks.full(); ++i) {
            const Eigen::Vector3d p_C = T_C_W * room_.points()[i];
            Eigen::Vector2d uv;
            if (p_C.z() < 0.3 || !ok(room_.camera().project(p_C, uv)) || !room_.camera().in_image(uv, 2.0)) {
                continue;
            }
            LandmarkSnapshot s;
            s.id = {4096 * number_ + static_cast<std::uint32_t>(i)};  // no track is longer than a keyframe
            s.p_W = T_O_W * room_.points()[i];
            s.covariance_W = 1e-4F * Eigen::Matrix3f::Identity();
            s.depth_m = static_cast<float>(p_C.z());
            s.depth_sigma_m = 0.01F;
            s.keyframes = 3;
            s.is_tracked = true;
            s.left_xy = p_C.head<2>() / p_C.z();
            s.left_px = uv.cast<float>();
            view_->landmarks.push_back(s);
        }
    }

    const TexturedRoom& room_;
    std::unique_ptr<KeyframeView> view_ = std::make_unique<KeyframeView>();
    SceneImage image_;
    std::deque<KeyframePose> window_;
    std::uint32_t number_ = 0;
};

}  // namespace facet::test
