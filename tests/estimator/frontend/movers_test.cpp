// SPDX-License-Identifier: BSD-2-Clause
// A part of the view that moves by itself: what the front-end drops of it, and what it no longer measures in stereo.
#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <random>

#include "tests/estimator/frontend/plane_flight.h"

namespace facet::movers_test {

using test::Flight;

namespace {

constexpr int kFrames = 16;
constexpr int kStill = 4;
// The part, in the left image (px); in the right one it is about the plane's disparity farther left.
constexpr int kLeft = 95;
constexpr int kRight = 225;
constexpr int kTop = 60;
constexpr int kBottom = 180;
constexpr int kDisparity = 9;

bool is_within(const FeatureObservation& o, int margin) {
    return o.left_px.x() > static_cast<float>(kLeft - margin) && o.left_px.x() < static_cast<float>(kRight + margin) &&
           o.left_px.y() > static_cast<float>(kTop - margin) && o.left_px.y() < static_cast<float>(kBottom + margin);
}

void paste(const synthetic::Image& from, int shift, synthetic::Image& to) {
    for (int v = kTop; v < kBottom; ++v) {
        for (int u = kLeft - shift; u < kRight - shift; ++u) {
            const auto at = static_cast<std::size_t>(v * to.width + u);
            to.pixels[at] = from.pixels[at];
        }
    }
}

/// Way of the camera per second while it flies, in W.
Eigen::Vector3d velocity_W(const Flight& f) {
    return (f.frames[kFrames - 1].T_W_B.p - f.frames[kFrames - 2].T_W_B.p) / test::kFramePeriod_s;
}

/// The flight, but the part shows another surface, which moves with this velocity while the camera flies.
Flight with_mover(const Eigen::Vector3d& velocity) {
    Flight f(kFrames, kStill);
    const synthetic::Texture texture(0.11, 0.8, 7);
    for (int k = 0; k < kFrames; ++k) {
        auto& frame = f.frames[static_cast<std::size_t>(k)];
        Se3 T_M_B = frame.T_W_B;  // as the mover sees it
        T_M_B.p -= test::kFramePeriod_s * std::max(0, k - kStill) * velocity;
        paste(synthetic::render(f.plane, texture, f.rig.left, T_M_B * f.rig.T_B_C0), 0, frame.left);
        paste(synthetic::render(f.plane, texture, f.rig.right, T_M_B * f.rig.T_B_C1), kDisparity, frame.right);
    }
    return f;
}

}  // namespace

TEST_CASE("what moves across the flow of the view is dropped, and nothing else", "[frontend]") {
    // GIVEN a part that moves at right angles to the flight, as the camera sees it
    const Flight still(kFrames, kStill);
    const Eigen::Quaterniond q_W_C = still.frames[kFrames - 1].T_W_B.q * still.rig.T_B_C0.q;
    const Eigen::Vector3d v_C = q_W_C.conjugate() * velocity_W(still);
    const Flight f = with_mover(q_W_C * (0.6 * Eigen::Vector3d(-v_C.y(), v_C.x(), 0.0).normalized()));
    Frontend frontend;
    REQUIRE(ok(frontend.configure(test::small_config(), f.rig)));
    // WHEN it is followed
    std::map<LandmarkId, bool> started_within;
    int outliers = 0;
    int aged_within = 0;
    int aged_beside = 0;
    for (std::size_t k = 0; k < f.frames.size(); ++k) {
        CAPTURE(k);
        FrontendOutput out;
        REQUIRE(ok(frontend.process(f.frames[k].view(), f.hints(k), out)));
        outliers += out.outliers;
        aged_within = aged_beside = 0;
        for (const FeatureObservation& o : out.observations) {
            started_within.try_emplace(o.landmark, is_within(o, 8));
            const bool is_aged = o.age_frames >= kFrames - kStill;  // from before it moved
            aged_within += is_aged && started_within[o.landmark] ? 1 : 0;
            aged_beside += is_aged && !started_within[o.landmark] ? 1 : 0;
        }
        CHECK((k > kStill || outliers == 0));
    }
    // THEN none of its first tracks is left, and most of the others are.
    CHECK(outliers > 15);
    CHECK(aged_within == 0);
    CHECK(aged_beside > 40);
}

TEST_CASE("what moves along the flow keeps its tracks, but not its stereo", "[frontend]") {
    // GIVEN a part that moves with half the camera's velocity, which no epipolar line contradicts
    const Flight f = with_mover(0.5 * velocity_W(Flight(kFrames, kStill)));
    Frontend frontend;
    REQUIRE(ok(frontend.configure(test::small_config(), f.rig)));
    std::map<LandmarkId, int> matched;  // keyframes
    int kept = 0;
    int refused = 0;
    int refused_beside = 0;
    for (std::size_t k = 0; k < f.frames.size(); ++k) {
        FrontendOutput out;
        REQUIRE(ok(frontend.process(f.frames[k].view(), f.hints(k), out)));
        if (!out.is_keyframe) {
            continue;
        }
        for (const FeatureObservation& o : out.observations) {
            const bool had_depth = matched[o.landmark] > 0;
            matched[o.landmark] += o.has_right ? 1 : 0;
            if (k <= kStill || !had_depth) {
                continue;
            }
            // THEN tracks that had a depth lose it at the next keyframe if they are of the mover, and only there.
            kept += o.has_right ? 1 : 0;
            refused += !o.has_right && is_within(o, -12) ? 1 : 0;
            refused_beside += !o.has_right && !is_within(o, 12) ? 1 : 0;
        }
    }
    CHECK(kept > 100);
    CHECK(refused > 15);
    CHECK(refused_beside < refused / 3);
}

namespace {

/// A vehicle that turns and flies before a plane, with a pattern in front of the left camera that turns with it.
Flight with_pattern(int frames, int right) {
    Flight f(frames, kStill);
    const Flight other(1, 0);
    for (auto& frame : f.frames) {
        for (int v = 0; v < frame.left.height; ++v) {
            for (int u = 0; u < right; ++u) {
                frame.left.pixels[static_cast<std::size_t>(v * frame.left.width + u)] =
                    other.frames[0].left.pixels[static_cast<std::size_t>(v * other.frames[0].left.width + u)];
            }
        }
    }
    return f;
}

int tracks_left_of(const FrontendOutput& out, int right) {
    return static_cast<int>(std::count_if(out.observations.begin(), out.observations.end(), [right](const auto& o) {
        return o.left_px.x() < static_cast<float>(right);
    }));
}

}  // namespace

TEST_CASE("what turns with the vehicle is left out, and its share is reported", "[frontend]") {
    constexpr int kCount = 40;
    const bool is_majority = GENERATE(false, true);
    const bool is_contradicted = GENERATE(false, true);
    CAPTURE(is_majority, is_contradicted);
    const int edge = is_majority ? 200 : 100;
    const Flight f = with_pattern(kCount, edge);
    Frontend frontend;
    REQUIRE(ok(frontend.configure(test::small_config(), f.rig)));
    FrontendOutput out;
    for (std::size_t k = 0; k < f.frames.size(); ++k) {
        FrameHints hints = f.hints(k);
        hints.is_contradicted = is_contradicted;
        REQUIRE(ok(frontend.process(f.frames[k].view(), hints, out)));
        CHECK((k > kStill || out.fixed_share == 0.0));
    }
    const int beside = static_cast<int>(out.observations.size()) - tracks_left_of(out, edge);
    if (is_contradicted || !is_majority) {
        CHECK(out.fixed_share > (is_majority ? 0.1 : 0.005));
        CHECK(3 * tracks_left_of(out, edge) < beside);
    }
}

TEST_CASE("an emitter's dots are recognised while the vehicle turns, and images turn with it without them",
          "[frontend]") {
    // GIVEN dots that are fixed to the vehicle, and more of a corner than anything else in view
    constexpr int kCount = 40;
    Flight f(kCount, kStill);
    for (auto& frame : f.frames) {
        std::mt19937 random(5);
        for (int k = 0; k < 700; ++k) {
            const int u = 12 + static_cast<int>(random() % static_cast<unsigned>(frame.left.width - 16));
            const int v = 2 + static_cast<int>(random() % static_cast<unsigned>(frame.left.height - 5));
            for (const int at : {0, 1, 2, frame.left.width, frame.left.width + 1, frame.left.width + 2}) {
                const auto pixel = static_cast<std::size_t>(v * frame.left.width + u + at);
                frame.left.pixels[pixel] = 250;
                frame.right.pixels[pixel - kDisparity] = 250;
            }
        }
    }
    Frontend frontend;
    REQUIRE(ok(frontend.configure(test::small_config(), f.rig)));
    std::size_t found = 0;
    FrontendOutput out;
    for (std::size_t k = 0; k < f.frames.size(); ++k) {
        CAPTURE(k);
        FrameHints hints = f.hints(k);
        hints.is_contradicted = true;
        hints.wants_turn = true;
        REQUIRE(ok(frontend.process(f.frames[k].view(), hints, out)));
        CHECK_FALSE((found != 0 && out.shows_dots));
        if (out.shows_dots) {
            // WHEN they are taken out
            frontend.take_out_dots();
            found = k;
        } else if (found != 0 && k > found + 2) {
            // THEN what is tracked turns as the vehicle does.
            REQUIRE(out.has_turn);
            const auto begin = static_cast<std::size_t>(
                std::lround((out.turn_begin - f.frames[0].stamp).seconds() / test::kFramePeriod_s));
            const Eigen::Vector3d true_turn = so3_log(f.frames[begin].T_W_B.q.conjugate() * f.frames[k].T_W_B.q);
            CHECK((out.turn_B - true_turn).norm() < 0.2 * true_turn.norm());
            CHECK(out.fixed_share > 0.01);
        }
    }
    CHECK(found > kStill);
    CHECK(found < 30);
}

TEST_CASE("a mask keeps tracks and stereo matches out of it", "[frontend]") {
    const Flight& f = test::flight();
    const int width = f.rig.left.intrinsics().width;
    synthetic::Image mask(width, f.rig.left.intrinsics().height, 255);
    for (int v = 0; v < mask.height; ++v) {
        std::fill_n(mask.pixels.begin() + static_cast<std::ptrdiff_t>(v) * width, width / 2, std::uint8_t{0});
    }
    Frontend frontend;
    REQUIRE(ok(frontend.configure(test::small_config(), f.rig)));
    const std::vector<std::uint8_t> small(100, 255);
    CHECK(frontend.set_masks({small.data(), 10, 10, 10}, {}) == Status::kInvalidArgument);
    REQUIRE(ok(frontend.set_masks(mask.view(), mask.view())));
    FrontendOutput out;
    int matched = 0;
    for (std::size_t k = 0; k < f.frames.size(); ++k) {
        REQUIRE(ok(frontend.process(f.frames[k].view(), f.hints(k), out)));
        for (const FeatureObservation& o : out.observations) {
            CHECK(o.left_px.x() >= static_cast<float>(width / 2) - 0.5F);
            CHECK((!o.has_right || o.right_px.x() >= static_cast<float>(width / 2) - 0.5F));
            matched += o.has_right ? 1 : 0;
        }
    }
    CHECK(out.observations.size() > 20);
    CHECK(matched > 10);
}

}  // namespace facet::movers_test
