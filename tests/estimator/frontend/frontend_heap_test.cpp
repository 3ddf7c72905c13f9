// SPDX-License-Identifier: BSD-2-Clause
// The front-end takes nothing from the heap once it is configured.
#include <catch2/catch.hpp>

#include "estimator/frontend/frontend.h"
#include "tests/estimator/frontend/given_landmarks.h"
#include "tests/estimator/frontend/synthetic.h"
#include "tests/support/allocation_guard.h"

namespace facet::frontend_heap_test {

TEST_CASE("front-end allocates nothing: keyframes, tracked frames, darkness, recall, dropping", "[frontend]") {
    const StereoRig rig = synthetic::make_rig();
    const synthetic::Plane plane{Eigen::Vector3d(0.1, -0.2, 1.0).normalized(), 2.5};
    const synthetic::Texture texture(0.11, 0.8, 41);
    const synthetic::Image dark(320, 240, 0);
    FrontendConfig config;
    config.corners.min_distance_px = 12.0;
    config.keyframe_disparity_px = 4.0;
    Frontend frontend;
    REQUIRE(ok(frontend.configure(config, rig)));
    std::vector<LandmarkPrediction> predictions;
    int keyframes = 0;
    int recalled = 0;
    Eigen::Quaterniond q_before = Eigen::Quaterniond::Identity();
    for (int k = 0; k < 14; ++k) {
        const double s = 0.05 * k;
        const Se3 T_W_B{so3_exp({0.3 * s, -0.2 * s, -1.5 + 0.4 * s}), {0.5 * s, -0.2 * s, 0.3 * s}};
        const bool is_dark = k == 9;
        const synthetic::Image left = is_dark ? dark : synthetic::render(plane, texture, rig.left, T_W_B * rig.T_B_C0);
        const synthetic::Image right =
            is_dark ? dark : synthetic::render(plane, texture, rig.right, T_W_B * rig.T_B_C1);
        FrameHints hints;
        hints.q_Bp_B = k == 0 ? Eigen::Quaterniond::Identity() : q_before.conjugate() * T_W_B.q;
        test::GivenLandmarks landmarks(predictions);
        hints.landmarks = &landmarks;
        q_before = T_W_B.q;
        const StereoFrame frame{Timestamp{} + Duration::from_seconds(10.0 + s), left.view(), right.view()};
        FrontendOutput output;
        const test::AllocationGuard guard;
        const Status status = frontend.process(frame, hints, output);
        frontend.match_surface(output);
        if (k == 5) {
            const LandmarkId first = output.observations.front().landmark;
            frontend.drop_tracks({&first, 1});
        }
        const std::uint64_t allocations = guard.allocations();
        CAPTURE(k);
        REQUIRE(ok(status));
        CHECK(allocations == 0);
        keyframes += output.is_keyframe ? 1 : 0;
        recalled += output.recalled;
        if (output.observations.empty()) {
            continue;
        }
        predictions.clear();
        for (const FeatureObservation& o : output.observations) {
            predictions.push_back({o.landmark, true, o.left_xy, 0.4});
        }
        std::sort(predictions.begin(), predictions.end(),
                  [](const auto& a, const auto& b) { return a.landmark < b.landmark; });
    }
    CHECK(keyframes >= 3);
    CHECK(recalled > 0);
}

}  // namespace facet::frontend_heap_test
