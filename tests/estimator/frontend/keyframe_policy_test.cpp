// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/keyframe_policy.h"

#include <catch2/catch.hpp>
#include <string>

namespace facet::keyframe_policy_test {
namespace {

Timestamp at(double s) { return Timestamp{} + Duration::from_seconds(s); }

}  // namespace

TEST_CASE("keyframe policy table", "[frontend]") {
    struct Row {
        std::string name;
        double elapsed_s;
        int live;
        int before;
        double disparity_px;
        bool right_then;
        bool right_now;
        bool expected;
    };
    const Row rows[] = {
        {"nothing happened", 0.5, 100, 100, 0.0, true, true, false},
        {"overlap low", 0.3, 69, 100, 0.0, true, true, true},
        {"overlap just enough", 0.3, 70, 100, 0.0, true, true, false},
        {"overlap low, but too soon", 0.1, 10, 100, 0.0, true, true, false},
        {"all tracks lost, but too soon", 0.15, 0, 100, 0.0, true, true, false},
        {"all tracks lost", 0.2, 0, 100, 0.0, true, true, true},
        {"never had tracks", 0.2, 0, 0, 0.0, true, true, true},
        {"disparity high", 0.2, 100, 100, 8.1, true, true, true},
        {"disparity not high enough", 0.2, 100, 100, 7.9, true, true, false},
        {"disparity high, but too soon", 0.1, 100, 100, 50.0, true, true, false},
        {"right image back", 0.2, 100, 100, 0.0, false, true, true},
        {"right image back, but too soon", 0.1, 100, 100, 0.0, false, true, false},
        {"right image lost", 0.5, 100, 100, 0.0, true, false, false},
        {"right image still missing", 0.5, 100, 100, 0.0, false, false, false},
        {"standing still, long", 1.0, 100, 100, 0.0, true, true, true},
        {"stamps jitter", 0.9995, 100, 100, 0.0, true, true, true},
        {"standing still, not long", 0.95, 100, 100, 0.0, true, true, false},
    };
    for (const Row& row : rows) {
        CAPTURE(row.name);
        KeyframePolicy policy;
        policy.configure(FrontendConfig{});
        REQUIRE(policy.decide({at(10.0), 0, 0, 0.0, row.right_then}));
        CHECK(policy.decide({at(10.0 + row.elapsed_s), row.live, row.before, row.disparity_px, row.right_now}) ==
              row.expected);
    }
}

TEST_CASE("standing still, keyframes come once a second", "[frontend]") {
    KeyframePolicy policy;
    policy.configure(FrontendConfig{});
    int keyframes = 0;
    for (int i = 0; i <= 200; ++i) {
        keyframes += policy.decide({at(0.05 * i), 300, 300, 0.02, true}) ? 1 : 0;
    }
    CHECK(keyframes == 11);
    policy.reset();
    CHECK(policy.decide({at(0.0), 300, 300, 0.0, true}));
}

}  // namespace facet::keyframe_policy_test
