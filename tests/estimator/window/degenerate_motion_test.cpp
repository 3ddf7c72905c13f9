// SPDX-License-Identifier: BSD-2-Clause
// Self-calibration by motions that reveal only some of the parameters: the others stay at their prior, and say so.
#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>
#include <string_view>
#include <vector>

#include "estimator/window/window.h"
#include "tests/support/synthetic_flight.h"

namespace facet::degenerate_motion_test {

using facet::test::SyntheticFlight;
using facet::test::SyntheticMotion;

namespace {

using Tangent = RigCalibration::Tangent;
using StateMatrix = Eigen::Matrix<double, kStateDim, kStateDim>;

/// A motion, what is wrong with the calibration, and what must come of it.
struct Case {
    std::string_view name;
    SyntheticMotion motion;
    bool rests = false;          ///< as images and inertial samples tell
    double time_offset_s = 0.0;  ///< true one
    Eigen::Vector3d rig_rotation = Eigen::Vector3d::Zero();
    std::vector<int> hidden;    ///< parameters of which the motion tells nothing
    std::vector<int> revealed;  ///< parameters that must be known at least three times as well as before
};

struct Found {
    Tangent value;
    Tangent sigma;
    Tangent prior;  ///< standard deviations, for the quality of the calibration that has been learnt
};

CalibrationConfig wide_calibration() {
    CalibrationConfig calibration;
    calibration.estimate_extrinsics = true;  // 0.01 rad and 5 mm: else no motion says more than the prior
    return calibration;
}

/// The rig of the flight with lenses that have a distortion to be corrected; observations are undistorted anyway.
StereoRig distorted(StereoRig rig) {
    for (CameraModel* camera : {&rig.left, &rig.right}) {
        CameraIntrinsics k = camera->intrinsics();
        k.distortion = Distortion::kRadialTangential;
        k.coeffs = {-0.28, 0.07, 0.0, 0.0};
        *camera = CameraModel(k);
    }
    return rig;
}

/// Twelve seconds of five keyframes each.
Found fly(const Case& c, unsigned seed) {
    SyntheticFlight::Options options;
    options.gyro_noise = 1.7e-4;
    options.accel_noise = 2e-3;
    options.pixel_sigma = 0.2;
    options.seed = seed;
    options.motion = c.motion;
    options.time_offset_s = c.time_offset_s;
    options.rig_rotation = c.rig_rotation;
    SyntheticFlight flight(options);
    const ImuNoise noise = test::euroc_like_noise();
    WindowConfig config;
    config.keyframes = 12;
    config.pixel_sigma_px = 0.2;
    const auto window = std::make_unique<Window>();
    window->configure(config, wide_calibration(), distorted(flight.rig()), noise);
    const StateMatrix information = test::start_sigmas().cwiseAbs2().cwiseInverse().asDiagonal();
    double before = 0.0;  // IMU time of the last keyframe
    for (int k = 0; k <= 60; ++k) {
        const double t = 0.2 * k + window->calibration().time_offset_s;
        const auto seen = flight.observe(0.2 * k);
        const KeyframeInput input{test::at(t), flight.rate(t), c.rests && k > 0, {seen.data(), seen.size()}};
        if (k == 0) {
            window->start(input, flight.state(t), information);
        } else {
            const Preintegration p = flight.preintegrate(before, t, window->newest().state.bias, noise);
            REQUIRE(ok(window->add_keyframe(input, p)));
            REQUIRE_FALSE(window->optimize().solver.solver_failed);
        }
        before = t;
    }
    StateMatrix covariance;
    REQUIRE(ok(window->newest_covariance(covariance)));
    Found found;
    found.value = RigCalibration{}.box_minus_to(window->calibration());
    for (int i = 0; i < wide_calibration().dim(); ++i) {
        found.sigma(i) = window->calibration_sigma(i);
        found.prior(i) = (i < kRigDim ? 1.0 : window->calibration_scale()) * wide_calibration().sigma(i);
    }
    return found;
}

SyntheticMotion motion(double yaw_rad, const Eigen::Vector3d& place_m, const Eigen::Vector3d& velocity_m_per_s) {
    return {yaw_rad, 0.0, 0.0, place_m, velocity_m_per_s};
}

std::vector<Case> cases() {
    const Eigen::Vector3d none = Eigen::Vector3d::Zero();
    const Eigen::Vector3d turned(0.01, -0.01, 0.01);
    const std::vector<int> pair{kTimeOffset, kRigTheta,   kRigTheta + 1, kRigTheta + 2,
                                kRigPos,     kRigPos + 1, kRigPos + 2};
    // One stereo view already tells something of the right camera against the left one; of scale it tells nothing.
    std::vector<int> pair_and_scale = pair;
    pair_and_scale.insert(pair_and_scale.end(), {kLeftLens, kRightLens});
    const std::vector<int> all_but_place{kTimeOffset, kRigTheta, kRigTheta + 1, kRigTheta + 2, kRightTheta + 2};
    return {
        {"standing", motion(0.0, none, none), true, 0.005, turned, pair_and_scale, {}},
        {"hover without rotation", motion(0.0, {0.05, 0.04, 0.03}, none), false, 0.005, turned, pair, {}},
        {"straight flight", motion(0.0, none, {0.25, 0.1, 0.0}), false, 0.005, turned, pair, {kRightTheta + 2}},
        {"yaw alone",
         motion(0.8, none, none),
         false,
         0.005,
         {0.0, 0.0, 0.01},  // about the axis of the motion
         {kRigTheta + 2, kRigPos, kRigPos + 1, kRigPos + 2},
         {kTimeOffset, kRigTheta, kRigTheta + 1, kRightTheta + 2}},
        {"planar flight",
         motion(0.8, {1.2, 0.9, 0.0}, none),
         false,
         0.005,
         turned,
         {kRigPos, kRigPos + 1, kRigPos + 2},
         all_but_place},
        {"lively flight", {}, false, 0.005, turned, {}, all_but_place},
    };
}

}  // namespace

TEST_CASE("parameters that a motion does not reveal stay at their prior", "[window]") {
    for (const Case& c : cases()) {
        for (const unsigned seed : {1U, 2U}) {
            const Found found = fly(c, seed);
            Tangent truth = Tangent::Zero();
            truth(kTimeOffset) = c.time_offset_s;
            truth.segment<3>(kRigTheta) = c.rig_rotation;
            for (int i = 0; i < wide_calibration().dim(); ++i) {
                CAPTURE(c.name, seed, i, found.value(i), truth(i), found.sigma(i));
                CHECK(std::abs(found.value(i) - truth(i)) < 3.5 * found.sigma(i));
                CHECK(found.sigma(i) < 1.003 * std::max(found.prior(i), wide_calibration().sigma(i)));
            }
            for (const int i : c.hidden) {
                const double prior = found.prior(i);
                CAPTURE(c.name, seed, i, found.value(i) / prior, found.sigma(i) / prior);
                CHECK(std::abs(found.value(i)) < 0.3 * prior);
                CHECK(found.sigma(i) > 0.94 * prior);
            }
            for (const int i : c.revealed) {
                CAPTURE(c.name, seed, i, found.value(i), truth(i), found.sigma(i));
                CHECK(found.sigma(i) < wide_calibration().sigma(i) / 3.0);
            }
        }
    }
}

}  // namespace facet::degenerate_motion_test
