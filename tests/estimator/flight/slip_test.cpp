// SPDX-License-Identifier: BSD-2-Clause
// Images that contradict the map, and what is claimed of the place while they do and after.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <vector>

#include "estimator/api/estimator.h"
#include "tests/support/still_vehicle.h"

namespace facet::slip_test {
namespace {

using test::StillVehicle;

constexpr double kFrame_s = 0.05;
constexpr int kStep_px = 4;
constexpr double kWay_m = 0.028;  // of a frame

/// A picture in strips, each moved by up to 4 px of its own: no motion of the vehicle explains that.
class Torn {
public:
    explicit Torn(const ImageView& image)
        : width_(image.width), pixels_(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height)) {
        for (int v = 0; v < image.height; ++v) {
            const int shift_px = v / kStrip_px * 3 % 5;
            std::copy_n(image.row(v) + shift_px, width_, pixels_.begin() + static_cast<std::ptrdiff_t>(v) * width_);
        }
    }
    ImageView view() const { return {pixels_.data(), width_, static_cast<int>(pixels_.size()) / width_, width_}; }

private:
    static constexpr int kStrip_px = 40;
    int width_;
    std::vector<std::uint8_t> pixels_;
};

/// A glide along the wall at 0.56 m/s.
class Glide {
public:
    Glide() {
        EstimatorConfig config;
        config.health.high_vision_chi2 = 2.0;
        REQUIRE(ok(estimator_->configure(config, vehicle_.rig)));
        for (int k = 0; k < 40; ++k) {
            add();
        }
    }
    /// @return the next frame's estimate
    Estimate add(bool is_torn = false) {
        const double t = 0.5 + kFrame_s * frames_;
        vehicle_.feed_imu(*estimator_, fed_s_, t + kFrame_s);
        fed_s_ = t + kFrame_s;
        StereoFrame frame = vehicle_.moved_frame(t, kStep_px * frames_++);
        const Torn left(frame.left);
        const Torn right(frame.right);
        if (is_torn) {
            frame.left = left.view();
            frame.right = right.view();
        }
        Estimate estimate;
        REQUIRE(ok(estimator_->add_frame(frame, estimate)));
        estimator_->finish_frame();
        return estimate;
    }
    /// To the second frame after a keyframe, which is in the window then.
    Estimate go_on_past_a_keyframe() {
        for (int k = 0; k < 20 && !add().health.is_keyframe; ++k) {
        }
        add();
        return add();
    }

private:
    StillVehicle vehicle_;
    std::unique_ptr<Estimator> estimator_ = std::make_unique<Estimator>();
    double fed_s_ = 0.0;
    int frames_ = 0;
};

bool is_odd(const Estimate& estimate) { return (estimate.health.reasons & kReasonHighResidual) != 0U; }

/// What the claimed standard deviation of the place along the wall has gained, as an independent error (m).
double gained_m(const Estimate& before, const Estimate& after) {
    const Eigen::Vector3d variance = (after.covariance - before.covariance).diagonal().segment<3>(3);
    return std::sqrt(std::max(0.0, variance.maxCoeff()));
}

TEST_CASE("one odd image between two that agree with the map costs the place nothing for good", "[estimator]") {
    Glide glide;
    const Estimate before = glide.go_on_past_a_keyframe();
    REQUIRE_FALSE(is_odd(before));
    REQUIRE_FALSE(before.health.is_keyframe);
    const Estimate odd = glide.add(true);
    REQUIRE_FALSE(odd.health.is_keyframe);
    REQUIRE(is_odd(odd));
    CHECK(odd.health.state == TrackingState::kDegraded);
    CHECK(gained_m(before, odd) == Approx(kWay_m).epsilon(0.2));
    const Estimate after = glide.add();
    CHECK_FALSE(is_odd(after));
    CHECK(gained_m(before, after) < 0.2 * kWay_m);
}

TEST_CASE("images that stay odd up to a keyframe leave the place as uncertain as the way flown", "[estimator]") {
    Glide glide;
    const Estimate before = glide.go_on_past_a_keyframe();
    int odd = 0;
    bool has_keyframe = false;
    for (int k = 0; k < 10; ++k) {
        const Estimate estimate = glide.add(true);
        odd += is_odd(estimate) ? 1 : 0;
        has_keyframe = has_keyframe || (is_odd(estimate) && estimate.health.is_keyframe);
    }
    CAPTURE(odd);
    REQUIRE(odd >= 2);
    REQUIRE(has_keyframe);
    Estimate after;
    for (int k = 0; k < 10; ++k) {
        after = glide.add();
    }
    CHECK_FALSE(is_odd(after));
    CHECK(gained_m(before, after) > 0.9 * kWay_m * odd);
}

}  // namespace
}  // namespace facet::slip_test
