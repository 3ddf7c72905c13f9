// SPDX-License-Identifier: BSD-2-Clause
// Made-up surfaces seen by a stereo camera that moves a little: landmarks with the noise such a camera has.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <memory>
#include <random>
#include <vector>

#include "mesh/mesher.h"
#include "mesh/planes/plane_finder.h"
#include "tests/support/ideal_camera.h"

namespace facet::test {

inline CameraModel plane_camera() { return ideal_camera(752, 480, 450.0); }

/// Camera at p that looks along azimuth `yaw`, `down` below the horizon (rad), upright.
inline Se3 looking(const Eigen::Vector3d& p, double yaw, double down) {
    const Eigen::Vector3d z(std::cos(yaw) * std::cos(down), std::sin(yaw) * std::cos(down), -std::sin(down));
    const Eigen::Vector3d x(std::sin(yaw), -std::cos(yaw), 0.0);
    Eigen::Matrix3d R;
    R << x, z.cross(x), z;
    return {Eigen::Quaterniond(R), p};
}

/// A landmark of a made-up world.
struct WorldPoint {
    Eigen::Vector3d p = Eigen::Vector3d::Zero();      ///< true place
    Eigen::Vector3d noise = Eigen::Vector3d::Zero();  ///< in standard deviations: across, across, along the ray
    int surface = 0;
};

struct PlaneWorld {
    std::vector<WorldPoint> points;  ///< the index is the landmark's id
    int surfaces = 0;
    double noise_px = 0.20;  ///< of disparity, after several keyframes; 0.3 of that across the ray
    std::mt19937 random{7};

    /// Landmarks on corner + u a + v b + h(u, v) n, u in [0, |a|), v in [0, |b|) along the sides, n = a x b; a jittered
    /// grid.
    /// @return number of the surface
    int add(
        const Eigen::Vector3d& corner, const Eigen::Vector3d& a, const Eigen::Vector3d& b, double step,
        const std::function<double(double, double)>& h = [](double, double) { return 0.0; }) {
        std::uniform_real_distribution<double> jitter(-0.3, 0.3);
        const Eigen::Vector3d n = a.cross(b).normalized();
        for (double u = 0.5 * step; u < a.norm(); u += step) {
            for (double v = 0.5 * step; v < b.norm(); v += step) {
                const double uu = u + step * jitter(random);
                const double vv = v + step * jitter(random);
                add_point(corner + uu * a.normalized() + vv * b.normalized() + h(uu, vv) * n);
            }
        }
        return surfaces++;
    }
    void add_point(const Eigen::Vector3d& p) {
        std::normal_distribution<double> gauss;
        WorldPoint point;
        point.p = p;
        point.noise = {gauss(random), gauss(random), gauss(random)};
        point.surface = surfaces;
        points.push_back(point);
    }
    int count(int surface) const {
        return static_cast<int>(
            std::count_if(points.begin(), points.end(), [=](const WorldPoint& p) { return p.surface == surface; }));
    }
};

/// A floor at z = 0, a wall x = 4 facing -x and a wall y = 2 facing -y.
struct Corner : PlaneWorld {
    int floor = add({0.5, -2.0, 0.0}, {3.5, 0.0, 0.0}, {0.0, 4.0, 0.0}, 0.25);
    int front = add({4.0, 2.0, 0.0}, {0.0, -4.0, 0.0}, {0.0, 0.0, 2.4}, 0.25);
    int side = add({0.5, 2.0, 0.0}, {3.5, 0.0, 0.0}, {0.0, 0.0, 2.4}, 0.25);
};

/// Sees all three.
inline const Se3 kCorner = looking({0.0, 0.0, 1.3}, 0.25, 0.25);

/// The proposal that is turned like n, if any.
inline const PlaneProposal* find_like(const PlaneProposals& proposals, const Eigen::Vector3d& n) {
    const auto at = std::find_if(proposals.begin(), proposals.end(),
                                 [&](const PlaneProposal& p) { return p.normal_W.dot(n) > 0.95; });
    return at == proposals.end() ? nullptr : &*at;
}

/// What the estimator would tell: all landmarks in the image are tracked; others, once seen, stay for a while.
class WorldViewer {
public:
    explicit WorldViewer(const PlaneWorld& world) : world_(world), last_seen_(world.points.size(), -1000) {}

    Eigen::Vector3d shift = Eigen::Vector3d::Zero();  ///< of everything in W: drift taken out, say
    int memory = 12;                                  ///< keyframes that a landmark stays unseen
    /// Points that are no landmarks are surface points of each keyframe that sees them.
    std::function<bool(std::size_t)> is_landmark = [](std::size_t) { return true; };

    /// View number `number`, one a second.
    const KeyframeView& view(int number, const Se3& T_W_C0) {
        KeyframeView& v = *view_;
        v.number = static_cast<std::uint32_t>(number);
        v.stamp = {1'000'000'000LL * number};
        v.oldest_stamp = {1'000'000'000LL * (number - memory)};
        v.T_W_C0 = {T_W_C0.q, T_W_C0.p + shift};
        v.landmarks.clear();
        v.surface.clear();
        if (v.keyframes.full()) {
            v.keyframes.clear();
        }
        v.keyframes.push_back({v.stamp, v.T_W_C0});
        for (std::size_t i = 0; i < world_.points.size() && !v.landmarks.full(); ++i) {
            const Eigen::Vector3d p_C = T_W_C0.inverse() * world_.points[i].p;
            Eigen::Vector2d uv;
            const bool is_seen =
                ok(plane_camera().project(p_C, uv)) && plane_camera().in_image(uv, 1.0) && p_C.z() < 7.0;
            last_seen_[i] = is_seen ? number : last_seen_[i];
            if (is_landmark(i) && number - last_seen_[i] <= memory) {
                v.landmarks.push_back(snapshot(i, number, T_W_C0, p_C, uv, is_seen));
            } else if (!is_landmark(i) && is_seen && !v.surface.full()) {
                LandmarkSnapshot s = snapshot(i, number, T_W_C0, p_C, uv, true);
                s.id.value += static_cast<std::uint32_t>(number) * kSurfaceIds;
                s.first_stamp = v.stamp;
                s.keyframes = s.stereo = 1;
                v.surface.push_back(s);
            }
        }
        return v;
    }
    KeyframeView& last() { return *view_; }
    static constexpr std::uint32_t kSurfaceIds = 100000;  ///< surface points have ids from here on

private:
    LandmarkSnapshot snapshot(std::size_t i, int number, const Se3& T_W_C0, const Eigen::Vector3d& p_C,
                              const Eigen::Vector2d& uv, bool is_seen) const {
        const WorldPoint& point = world_.points[i];
        const double z = std::max(0.5, std::abs(p_C.z()));
        const double across = 0.3 * world_.noise_px * z / 450.0;
        const double along = world_.noise_px * z * z / (450.0 * 0.11);
        // The frame of the ray: its error mostly along it.
        Eigen::Matrix3d R;
        R.col(2) = p_C.normalized();
        R.col(0) = R.col(2).unitOrthogonal();
        R.col(1) = R.col(2).cross(R.col(0));
        const Eigen::Matrix3d R_W = T_W_C0.R() * R;
        const Eigen::Vector3d sigma(across, across, along);
        LandmarkSnapshot s;
        s.id = {static_cast<std::uint32_t>(i)};
        s.p_W = point.p + shift + R_W * sigma.cwiseProduct(point.noise);
        s.covariance_W = (R_W * sigma.cwiseAbs2().asDiagonal() * R_W.transpose()).cast<float>();
        s.chi2 = 1.0F;
        s.depth_m = static_cast<float>(p_C.z());
        s.depth_sigma_m = static_cast<float>(along);
        s.keyframes = 4;
        s.stereo = 4;
        s.first_stamp = {1'000'000'000LL * (number - 3)};
        s.unseen_keyframes = number - last_seen_[i];
        s.is_tracked = is_seen;
        s.left_xy = p_C.head<2>() / p_C.z();
        s.left_px = uv.cast<float>();
        return s;
    }

    const PlaneWorld& world_;
    std::vector<int> last_seen_;
    std::unique_ptr<KeyframeView> view_ = std::make_unique<KeyframeView>();
};

/// Mesher and finder on a world, from keyframe to keyframe.
class PlaneRig {
public:
    explicit PlaneRig(const PlaneWorld& world, const PlaneConfig& config = {}) : viewer(world) {
        REQUIRE(ok(mesher->configure({}, plane_camera())));
        REQUIRE(ok(finder->configure(config)));
    }

    const PlaneProposals& step(const Se3& T_W_C0) { return step_on(viewer.view(++number, T_W_C0)); }
    const PlaneProposals& step_on(const KeyframeView& view) {
        mesher->update(view, {});
        const PlaneProposals& proposals = finder->update(mesher->mesh(), view);
        finder->label(mesher->mesh());
        finder->flatten(mesher->mesh());
        return proposals;
    }
    /// Some keyframes with a little motion sideways.
    const PlaneProposals& hover(const Se3& T_W_C0, int keyframes) {
        for (int k = 0; k < keyframes; ++k) {
            step({T_W_C0.q, T_W_C0.p + T_W_C0.R().col(0) * 0.04 * (k % 4)});
        }
        return finder->proposals();
    }

    WorldViewer viewer;
    std::unique_ptr<Mesher> mesher = std::make_unique<Mesher>();
    std::unique_ptr<PlaneFinder> finder = std::make_unique<PlaneFinder>();
    int number = 0;
};

/// Most planes ever told in some keyframes.
inline std::size_t most_planes(const PlaneWorld& world, const Se3& camera, int keyframes = 10,
                               bool find_slanted = true) {
    PlaneConfig config;
    config.find_slanted = find_slanted;
    PlaneRig rig(world, config);
    std::size_t most = 0;
    for (int k = 0; k < keyframes; ++k) {
        most = std::max(most, rig.hover(camera, 1).size());
        rig.viewer.memory = 30;
    }
    return most;
}

}  // namespace facet::test
