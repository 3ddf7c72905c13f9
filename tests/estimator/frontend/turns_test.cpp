// SPDX-License-Identifier: BSD-2-Clause
// How tracks take turns between keyframes.
#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <vector>

#include "estimator/frontend/frontend.h"
#include "tests/estimator/frontend/plane_flight.h"

namespace facet::turns_test {

using test::flight;
using test::Flight;

TEST_CASE("between keyframes tracks take turns if there are enough of them", "[frontend]") {
    const Flight& f = flight();
    Frontend frontend;
    FrontendConfig config = test::small_config();
    config.max_features = GENERATE(150, 300);
    config.corners.min_distance_px = 6.0;
    config.keyframe_disparity_px = 12.0;
    CAPTURE(config.max_features);
    REQUIRE(ok(frontend.configure(config, f.rig)));
    std::map<LandmarkId, Eigen::Vector3d> points;
    std::map<LandmarkId, std::size_t> seen;  // the last frame that saw it
    int shared = 0;
    for (std::size_t k = 0; k < f.frames.size(); ++k) {
        CAPTURE(k);
        FrontendOutput out;
        REQUIRE(ok(frontend.process(f.frames[k].view(), f.hints(k), out)));
        const Se3 T_W_C = f.frames[k].T_W_B * f.rig.T_B_C0;
        std::vector<double> errors_px;
        for (const FeatureObservation& o : out.observations) {
            if (points.try_emplace(o.landmark, f.plane.intersect(T_W_C.p, T_W_C.q * o.left_xy.homogeneous())).second) {
                CHECK(out.is_keyframe);
                CHECK(o.age_frames == 0);
            } else {
                CHECK(k - seen[o.landmark] <= 2);
                CHECK(o.age_frames >= k - seen[o.landmark]);
            }
            const Eigen::Vector3d p_C = T_W_C.inverse() * points[o.landmark];
            errors_px.push_back((p_C.hnormalized() - o.left_xy).norm() * f.rig.left.focal_px());
            seen[o.landmark] = k;
        }
        std::sort(errors_px.begin(), errors_px.end());
        CHECK(errors_px[errors_px.size() / 2] < 0.2);
        const bool has_new = std::any_of(out.observations.begin(), out.observations.end(),
                                         [](const FeatureObservation& o) { return o.age_frames == 1; });
        if (out.is_keyframe || out.tracked < 180) {
            CHECK(static_cast<int>(out.observations.size()) == out.tracked + out.detected + out.recalled);
        } else if (out.tracked >= 200 && !has_new) {  // new tracks are followed at once
            CHECK(out.observations.size() > 0.4 * out.tracked);
            CHECK(out.observations.size() < 0.6 * out.tracked);
            ++shared;
        }
    }
    CHECK((shared > 5) == (config.max_features > 200));
}

TEST_CASE("all tracks are followed in a frame that is not like those before it, and where something is in doubt",
          "[frontend]") {
    const Flight& f = flight();
    Frontend frontend;
    FrontendConfig config = test::small_config();
    config.max_features = 300;
    config.corners.min_distance_px = 6.0;
    config.keyframe_disparity_px = 30.0;
    REQUIRE(ok(frontend.configure(config, f.rig)));
    FrontendOutput out;
    for (std::size_t k = 0; k < 12; ++k) {
        REQUIRE(ok(frontend.process(f.frames[k].view(), f.hints(k), out)));
    }
    REQUIRE_FALSE(out.is_keyframe);
    REQUIRE(out.tracked >= 200);
    REQUIRE(out.observations.size() < 0.6 * out.tracked);
    StereoFrame next = f.frames[12].view();
    FrameHints hints = f.hints(12);
    if (GENERATE(true, false)) {
        next.left = next.right;  // another camera's: everything jumps to the left
    } else {
        hints.is_uncertain = true;
    }
    REQUIRE(ok(frontend.process(next, hints, out)));
    REQUIRE_FALSE(out.is_keyframe);
    CHECK(out.observations.size() > 150);
    CHECK(static_cast<int>(out.observations.size()) == out.tracked);
}

}  // namespace facet::turns_test
