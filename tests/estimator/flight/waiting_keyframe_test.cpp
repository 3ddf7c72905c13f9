// SPDX-License-Identifier: BSD-2-Clause
// A keyframe whose turn in the window comes after the estimate of the frame that follows it.
#include <catch2/catch.hpp>
#include <memory>

#include "estimator/api/estimator.h"
#include "tests/support/still_vehicle.h"

namespace facet::waiting_keyframe_test {
namespace {

using test::StillVehicle;

constexpr double kBegin_s = 0.5;
constexpr double kFrame_s = 0.05;
constexpr int kStep_px = 4;

/// A glide along the wall.
class Glide {
public:
    explicit Glide(bool spreads = true) {
        EstimatorConfig config;
        config.window.spread_keyframes = spreads;
        REQUIRE(ok(estimator->configure(config, vehicle.rig)));
    }
    StereoFrame frame(int k, bool dark = false) const {
        const double t = kBegin_s + kFrame_s * k;
        return dark ? vehicle.frame(t, true) : vehicle.moved_frame(t, kStep_px * k);
    }
    void feed_until(double t) {
        vehicle.feed_imu(*estimator, fed_s, t);
        fed_s = t;
    }
    Estimate add(int k, bool dark = false) {
        // A frame ahead: the clocks' offset may put the frame's time later.
        feed_until(kBegin_s + kFrame_s * (k + 1));
        Estimate estimate;
        REQUIRE(ok(estimator->add_frame(frame(k, dark), estimate)));
        return estimate;
    }
    /// Frames from `k` on until a keyframe waits. @return its estimate
    Estimate go_on_until_one_waits(int& k) {
        for (const int end = k + 40; k < end; ++k) {
            const Estimate estimate = add(k);
            estimator->finish_frame();
            if (estimator->keyframe_waits()) {
                return estimate;
            }
        }
        FAIL("no keyframe waits");
        return {};
    }

    StillVehicle vehicle;
    std::unique_ptr<Estimator> estimator = std::make_unique<Estimator>();
    double fed_s = 0.0;
};

TEST_CASE("the window takes a keyframe after the next frame's estimate, and the view says whose it is") {
    Glide glide;
    int waited = 0;
    bool waits = false;
    bool was_taken = false;
    Timestamp keyframe;
    for (int k = 0; k < 80; ++k) {
        const std::uint32_t before = glide.estimator->keyframe_view().number;
        const Estimate estimate = glide.add(k);
        if (was_taken) {
            CHECK(estimate.health.iterations > 0);
        }
        was_taken = false;
        if (glide.estimator->keyframe_waits()) {
            ++waited;
            CHECK(estimate.health.is_keyframe);
            CHECK(estimate.health.iterations == 0);
            CHECK(estimate.health.state == TrackingState::kTracking);
            CHECK(estimate.health.map_landmarks > 50);  // told by the image
            keyframe = estimate.stamp;
            waits = true;
            glide.estimator->finish_frame();
            glide.estimator->finish_frame();  // once
            CHECK(glide.estimator->keyframe_waits());
            CHECK(glide.estimator->keyframe_view().number == before);
        } else if (waits) {
            glide.estimator->finish_frame();
            CHECK_FALSE(glide.estimator->keyframe_waits());
            CHECK(glide.estimator->keyframe_view().number == before + 1);
            CHECK(glide.estimator->keyframe_view().stamp == keyframe);
            CHECK_FALSE(glide.estimator->keyframe_view().surface.empty());
            waits = false;
            was_taken = true;
        } else {
            glide.estimator->finish_frame();
        }
    }
    CHECK(waited > 5);
}

TEST_CASE("no keyframe waits if that is not configured, while the vehicle stands, or before there is an estimate") {
    Glide at_once(false);
    for (int k = 0; k < 40; ++k) {
        at_once.add(k);
        CHECK_FALSE(at_once.estimator->keyframe_waits());
    }
    Glide standing;
    for (int k = 0; k < 40; ++k) {
        standing.feed_until(kBegin_s + kFrame_s * (k + 1));
        Estimate estimate;
        REQUIRE(ok(standing.estimator->add_frame(standing.vehicle.frame(kBegin_s + kFrame_s * k), estimate)));
        CHECK_FALSE(standing.estimator->keyframe_waits());
    }
}

TEST_CASE("a reset, dark images and a gap take a keyframe out of its waiting, whoever asks for views") {
    Glide asked;
    Glide plain;
    enum class Event { kReset, kDark, kGap, kRightAlone };
    const Event event = GENERATE(Event::kReset, Event::kDark, Event::kGap, Event::kRightAlone);
    CAPTURE(static_cast<int>(event));
    int at = 0;
    Estimate a;
    Estimate b;
    for (int k = 0; k < 100; ++k) {
        const bool happens = at == 0 && k > 30 && asked.estimator->keyframe_waits();
        at = happens ? k : at;
        const bool is_on = at != 0 && k < at + 12;
        if (event == Event::kGap && is_on) {
            continue;
        }
        if (event == Event::kReset && happens) {
            asked.estimator->request_reset();
            plain.estimator->request_reset();
        }
        StereoFrame frame = asked.frame(k, event == Event::kDark && is_on);
        if (event == Event::kRightAlone && is_on) {
            frame.left = {};
        }
        for (Glide* const glide : {&asked, &plain}) {
            glide->feed_until(kBegin_s + kFrame_s * (k + 1));
        }
        REQUIRE(ok(asked.estimator->add_frame(frame, a)));
        REQUIRE(ok(plain.estimator->add_frame(frame, b)));
        asked.estimator->finish_frame();
        CAPTURE(k, at);
        REQUIRE(a.state.p_W_B == b.state.p_W_B);
        REQUIRE(a.covariance == b.covariance);
        REQUIRE(a.health.reset_counter == b.health.reset_counter);
        REQUIRE(a.health.iterations == b.health.iterations);
    }
    REQUIRE(at != 0);
    CHECK(a.health.state == TrackingState::kTracking);
    CHECK(a.health.reset_counter == (event == Event::kReset || event == Event::kRightAlone ? 1U : 0U));
    const Eigen::Vector3d v_W = kStep_px / kFrame_s * asked.vehicle.way_of_pixel_B();
    CHECK((a.state.v_W_B - v_W).norm() < 0.05);
}

TEST_CASE("without frames the estimate is carried on from the window that has taken its last keyframe") {
    Glide glide;
    int k = 30;
    const Estimate last = glide.go_on_until_one_waits(k);
    const std::uint32_t before = glide.estimator->keyframe_view().number;
    glide.feed_until(kBegin_s + kFrame_s * k + 1.0);
    Estimate carried;
    REQUIRE(ok(glide.estimator->take_carried(carried)));
    CHECK_FALSE(glide.estimator->keyframe_waits());
    CHECK(glide.estimator->keyframe_view().number == before + 1);
    const double flown_s = (carried.stamp - last.stamp).seconds();
    CHECK(flown_s > 0.5);
    const Eigen::Vector3d way = kStep_px / kFrame_s * flown_s * glide.vehicle.way_of_pixel_B();
    CHECK((carried.state.p_W_B - last.state.p_W_B - way).norm() < 0.02);
}

}  // namespace
}  // namespace facet::waiting_keyframe_test
