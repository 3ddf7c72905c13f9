// SPDX-License-Identifier: BSD-2-Clause
// Mesher and plane finder, fed with landmarks that lie on surfaces, on each other, on a line, anywhere, or far away.
#include <cmath>
#include <limits>
#include <memory>

#include "mesh/mesher.h"
#include "mesh/planes/plane_finder.h"
#include "tests/fuzz/fuzz_input.h"
#include "tests/support/ideal_camera.h"

using namespace facet;
using facet::test::FuzzInput;

namespace {

constexpr int kKeyframes = 6;  // more than it takes to confirm a plane
constexpr int kPoints = 120;

/// Where a landmark is in the camera's image, and how far: on one of two walls, a floor, a line, or anywhere.
Eigen::Vector3d take_point(FuzzInput& input, int form) {
    const double u = input.take<std::int8_t>() / 170.0;
    const double v = input.take<std::int8_t>() / 260.0;
    const Eigen::Vector3d ray(u, v, 1.0);
    switch (form % 6) {
        case 0: return 3.0 * ray;                                       // a wall across the view
        case 1: return ray * (1.2 / std::max(0.05, std::abs(v)));       // a floor, or a ceiling
        case 2: return ray * (1.5 / std::max(0.05, std::abs(u)));       // walls beside
        case 3: return {u, 0.0, 2.0};                                   // a line
        case 4: return ray * (0.2 + input.take<std::uint8_t>() / 8.0);  // anywhere
        default: return ray * std::abs(static_cast<double>(input.take<float>()));
    }
}

float take_sigma(FuzzInput& input) {
    const auto what = input.take<std::uint8_t>();
    switch (what) {
        case 0: return 0.0F;
        case 1: return 1e6F;
        case 2: return 1e-12F;
        default: return 1e-4F * static_cast<float>(what);
    }
}

LandmarkSnapshot take_landmark(FuzzInput& input, std::uint32_t id, const KeyframeView& view) {
    const auto what = input.take<std::uint8_t>();
    const Eigen::Vector3d p_C = take_point(input, what);
    LandmarkSnapshot s;
    s.id = {id};
    s.p_W = view.T_W_C0 * p_C;
    const float sigma = take_sigma(input);
    s.covariance_W = sigma * sigma * Eigen::Matrix3f::Identity();
    s.chi2 = static_cast<float>(what % 16) / 4.0F;
    s.depth_m = static_cast<float>(p_C.z());
    s.depth_sigma_m = sigma;
    s.keyframes = s.stereo = 1 + what % 5;
    s.first_stamp = view.oldest_stamp;
    s.is_tracked = (what & 32U) == 0;
    s.unseen_keyframes = s.is_tracked ? 0 : 1 + what % 3;
    s.left_xy = {p_C.x() / p_C.z(), p_C.y() / p_C.z()};
    s.left_px = {static_cast<float>(375.5 + 450.0 * s.left_xy.x()), static_cast<float>(239.5 + 450.0 * s.left_xy.y())};
    return s;
}

/// What the estimator would pass on: all numbers are finite, as it leaves out what it cannot triangulate.
void take_view(FuzzInput& input, int number, KeyframeView& view) {
    view.number = static_cast<std::uint32_t>(number);
    view.stamp = {1'000'000'000LL * number};
    view.oldest_stamp = {1'000'000'000LL * std::max(0, number - 5)};
    const double yaw = input.take<std::int8_t>() / 64.0;
    // z of the camera forward in W's horizontal plane, y down.
    const Eigen::Matrix3d level = (Eigen::Matrix3d() << 0, 0, 1, -1, 0, 0, 0, -1, 0).finished();
    view.T_W_C0.q = Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ())) * Eigen::Quaterniond(level);
    view.T_W_C0.p = {input.take<std::int8_t>() / 100.0, 0.0, 1.3};
    if (view.keyframes.full()) {
        view.keyframes.clear();
    }
    view.keyframes.push_back({view.stamp, view.T_W_C0});
    view.landmarks.clear();
    for (std::uint32_t i = 0; i < kPoints && !input.empty(); ++i) {
        const LandmarkSnapshot s = take_landmark(input, i, view);
        if (s.p_W.allFinite() && s.p_W.norm() < 1e6 && s.depth_m > 0.0F) {
            view.landmarks.push_back(s);
        }
    }
    // The estimator holds what it was told at the last keyframe, or a little beside it.
    for (PlaneEstimate& plane : view.planes) {
        plane.distance_m += input.take<std::int8_t>() / 1000.0;
    }
}

void check(const PlaneProposals& proposals) {
    for (const PlaneProposal& plane : proposals) {
        test::require(std::abs(plane.normal_W.norm() - 1.0) < 1e-6 && std::isfinite(plane.distance_m));
        test::require(plane.landmarks.size() >= 3);
        for (std::size_t i = 1; i < plane.landmarks.size(); ++i) {
            test::require(plane.landmarks[i - 1].value < plane.landmarks[i].value);
        }
    }
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    FuzzInput input(data, size);
    static const auto mesher = std::make_unique<Mesher>();
    static const auto finder = std::make_unique<PlaneFinder>();
    static const auto view = std::make_unique<KeyframeView>();
    test::require(ok(mesher->configure({}, test::ideal_camera(752, 480, 450.0))));
    test::require(ok(finder->configure({})));
    view->keyframes.clear();
    view->planes.clear();
    for (int number = 1; number <= kKeyframes && !input.empty(); ++number) {
        take_view(input, number, *view);
        mesher->update(*view, {});
        const PlaneProposals& proposals = finder->update(mesher->mesh(), *view);
        check(proposals);
        finder->label(mesher->mesh());
        finder->flatten(mesher->mesh());
        const HorizonMesh& mesh = mesher->mesh();
        for (int i = 0; i < mesh.vertex_end(); ++i) {
            test::require(!mesh.is_vertex(i) || mesh.vertex(static_cast<VertexSlot>(i)).shown_W().allFinite());
        }
        view->planes.clear();
        for (const PlaneProposal& plane : proposals) {
            view->planes.push_back({plane.id, plane.kind, plane.normal_W, plane.distance_m, 10});
        }
    }
    return 0;
}
