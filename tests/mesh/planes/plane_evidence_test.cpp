// SPDX-License-Identifier: BSD-2-Clause
// The search for a plane's landmarks against one that looks at every face in turn.
#include "mesh/planes/plane_evidence.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <random>
#include <set>

#include "platform/base/angle.h"
#include "tests/mesh/planes/plane_worlds.h"
#include "tests/support/allocation_guard.h"

namespace facet::plane_evidence_test {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

struct Found {
    std::set<std::uint32_t> landmarks;
    std::set<std::uint32_t> surface;
    double area_m2 = 0.0;
    int at_limits = 0;  ///< faces too near to a limit to say
};

/// Corners of the faces that are turned like the plane, near it, and have all corners within `gate_m` of it.
Found search(const HorizonMesh& mesh, const KeyframeView& view, const PlaneFit& fit, double gate_m) {
    constexpr double kNear_m = 0.30;
    constexpr double kDoubt = 1e-5;
    std::map<std::uint32_t, PlanePoint> known;
    for (const LandmarkSnapshot& s : view.landmarks) {
        known[s.id.value] = {s.p_W, s.covariance_W};
    }
    Found found;
    for (int f = 0; f < mesh.face_end(); ++f) {
        if (!mesh.is_face(f) || mesh.face(static_cast<FaceIndex>(f)).is_doubtful() ||
            mesh.face(static_cast<FaceIndex>(f)).is_fill) {
            continue;
        }
        const MeshFace& face = mesh.face(static_cast<FaceIndex>(f));
        std::array<PlanePoint, 3> corner;
        bool is_known = true;
        for (std::size_t k = 0; k < 3; ++k) {
            const MeshVertex& vertex = mesh.vertex(face.vertex[k]);
            const auto at = known.find(mesh.landmark(face.vertex[k]).value);
            is_known = is_known && !vertex.is_rehosted && (vertex.is_surface_point || at != known.end());
            corner[k] = vertex.is_surface_point ? PlanePoint{vertex.measured_W, vertex.covariance_W}
                        : at != known.end()     ? at->second
                                                : PlanePoint{};
        }
        if (!is_known) {
            continue;
        }
        const Vector3d a = corner[1].p_W - corner[0].p_W;
        const Vector3d b = corner[2].p_W - corner[0].p_W;
        const double sides = a.squaredNorm() + b.squaredNorm() + (a - b).squaredNorm();
        const double tilt =
            static_cast<double>(face.sigma_m) * std::sqrt(0.125 * sides) / static_cast<double>(face.area_m2);
        const double angle = std::acos(std::clamp(fit.normal_W.dot(a.cross(b).normalized()), -1.0, 1.0));
        const double widest = std::min(kRadPerDeg * PlaneLimits::kMaxFaceAngle_deg,
                                       kRadPerDeg * PlaneLimits::kFaceAngle_deg + 2.0 * tilt);
        const double height = std::abs(fit.residual((corner[0].p_W + corner[1].p_W + corner[2].p_W) / 3.0));
        bool is_on = angle <= widest && height <= kNear_m;
        bool is_doubtful = std::abs(angle - widest) < 10.0 * kDoubt || std::abs(height - kNear_m) < kDoubt;
        for (const PlanePoint& p : corner) {
            const double sigma = static_cast<double>(p.sigma_along(fit.normal_W.cast<float>()));
            is_on = is_on && std::abs(fit.residual(p.p_W)) <= gate_m && sigma <= PlaneLimits::kMaxPointSigma_m;
            is_doubtful = is_doubtful || std::abs(sigma - PlaneLimits::kMaxPointSigma_m) < kDoubt;
        }
        found.at_limits += is_doubtful ? 1 : 0;
        if (is_on) {
            found.area_m2 += static_cast<double>(face.area_m2);
            for (const VertexSlot v : face.vertex) {
                (mesh.vertex(v).is_surface_point ? found.surface : found.landmarks).insert(mesh.landmark(v).value);
            }
        }
    }
    return found;
}

TEST_CASE("the landmarks of a candidate are those that a plain search over all faces finds") {
    const test::Corner world;
    test::PlaneRig rig(world);
    rig.viewer.is_landmark = [](std::size_t i) { return i % 3 != 0; };
    rig.hover(test::kCorner, 6);
    const HorizonMesh& mesh = rig.mesher->mesh();
    const KeyframeView& view = rig.viewer.last();
    const PlaneConfig config;
    const auto evidence = std::make_unique<PlaneEvidence>();
    const auto support = std::make_unique<PlaneSupport>();
    std::mt19937 random(5);
    std::normal_distribution<double> gauss;
    const std::array<Vector3d, 3> normals{Vector3d::UnitZ(), -Vector3d::UnitX(), -Vector3d::UnitY()};
    const std::array<double, 3> distances{0.0, -4.0, -2.0};
    int compared = 0;
    for (int k = 0; k < 60; ++k) {
        const auto surface = static_cast<std::size_t>(k % 3);
        PlaneFit fit;
        fit.normal_W = (normals[surface] + 0.03 * Vector3d(gauss(random), gauss(random), gauss(random))).normalized();
        fit.distance_m = distances[surface] + 0.05 * gauss(random);
        const double gate_m = k % 2 == 0 ? 0.15 : 0.08;
        const Found expected = search(mesh, view, fit, gate_m);
        const test::AllocationGuard guard;
        evidence->take(config, mesh, view);
        evidence->collect(fit, 0, {gate_m, 1e3}, {}, *support);
        const std::uint64_t allocations = guard.allocations();
        REQUIRE(allocations == 0);
        if (expected.at_limits > 0) {
            continue;
        }
        Found found;
        for (const std::uint16_t p : support->points) {
            found.landmarks.insert(evidence->landmark(p).value);
        }
        for (const std::uint16_t p : support->surface) {
            found.surface.insert(evidence->landmark(p).value);
        }
        CHECK(found.landmarks == expected.landmarks);
        CHECK(found.surface == expected.surface);
        CHECK(support->area_m2 == Approx(expected.area_m2).epsilon(1e-9));
        CHECK(std::is_sorted(support->points.begin(), support->points.end()));
        compared += found.landmarks.empty() || found.surface.empty() ? 0 : 1;
    }
    CHECK(compared > 30);
}

}  // namespace
}  // namespace facet::plane_evidence_test
