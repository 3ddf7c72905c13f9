// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/calibrate/batch.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "app/lab/calibrate/batch_points.h"
#include "app/lab/calibrate/sighting_cost.h"
#include "app/lab/faults/calibration_error.h"
#include "app/lab/sim/default_rig.h"
#include "app/support/rng.h"
#include "tests/support/synthetic_flight.h"

namespace facet::batch_test {
namespace {

constexpr double kPixelSigma = 0.05;

/// Lenses as real ones bend, on the synthetic flight's mounts.
StereoRig true_rig() {
    StereoRig rig = test::make_rig();
    rig.left = sim::euroc_rig().left;
    rig.right = sim::euroc_rig().right;
    return rig;
}

/// What a camera with noise sees of a point in its frame. @return false if it does not
bool see(const CameraModel& camera, const Eigen::Vector3d& p_C, RandomStream& random, Eigen::Vector2d& px) {
    if (p_C.z() < 0.2 || !ok(camera.project(p_C, px)) || !camera.in_image(px, 5.0)) {
        return false;
    }
    px += kPixelSigma * Eigen::Vector2d(random.normal(), random.normal());
    return true;
}

/// Keyframes four times a second, with states that are a little off.
RecordedFlight fly(double seconds, double time_offset_s) {
    test::SyntheticFlight::Options options;
    options.gyro_noise = 1.7e-4;
    options.accel_noise = 2e-3;
    options.bias = {{0.01, -0.02, 0.005}, {0.05, 0.1, -0.05}};
    options.landmarks = 600;
    options.in_room = true;
    test::SyntheticFlight flight(options);
    RandomStream random(7, 1);
    const StereoRig rig = true_rig();
    RecordedFlight out;
    for (int i = 0; i <= static_cast<int>((seconds + 0.5) * 200.0); ++i) {
        out.imu.push_back(flight.imu(i / 200.0));
    }
    for (double t = 0.25; t < seconds; t += 0.25) {
        RecordedKeyframe keyframe;
        keyframe.stamp = test::at(t);
        keyframe.image_stamp = keyframe.stamp - Duration::from_seconds(time_offset_s);
        keyframe.state = flight.state(t);
        for (std::uint32_t i = 0; i < flight.landmarks().size(); ++i) {
            const Eigen::Vector3d p_B = keyframe.state.T_W_B().inverse() * flight.landmarks()[i];
            PointSighting s{.point = i};
            if (see(rig.left, rig.T_B_C0.inverse() * p_B, random, s.left_px)) {
                s.has_right = see(rig.right, rig.T_B_C1.inverse() * p_B, random, s.right_px);
                keyframe.sightings.push_back(s);
            }
        }
        keyframe.state.p_W_B += 0.01 * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
        keyframe.state.q_W_B = keyframe.state.q_W_B * so3_exp({2e-3 * random.normal(), 0.0, 2e-3 * random.normal()});
        keyframe.state.bias = {};
        out.keyframes.push_back(keyframe);
    }
    return out;
}

BatchOptions wrong_by(double factor, std::uint64_t seed) {
    BatchOptions options;
    options.given.rig = true_rig();
    if (factor > 0.0) {
        REQUIRE(add_calibration_error(factor, seed, options.given.rig));
    }
    options.prior_sigma = prior_sigmas(options.given.rig, 1.0);
    options.noise = test::euroc_like_noise();
    return options;
}

TEST_CASE("the batch finds the errors of a wrong calibration, and the time offset") {
    if (!has_batch_solver()) {
        WARN("built without Ceres");
        return;
    }
    const double time_offset_s = 0.003;
    const BatchOptions options = wrong_by(2.0, 5);
    BatchResult result;
    REQUIRE(ok(solve_batch(fly(15.0, time_offset_s), options, result)));
    RigAndTime refined;
    REQUIRE(ok(apply_correction(options.given, result.correction, refined)));
    const StereoRig truth = true_rig();
    const CameraIntrinsics& found = refined.rig.left.intrinsics();
    const CameraIntrinsics& expected = truth.left.intrinsics();
    CHECK(std::abs(found.cx - expected.cx) < 0.15);
    CHECK(std::abs(found.cy - expected.cy) < 0.15);
    CHECK(std::abs(found.fx / expected.fx - 1.0) < 5e-4);
    CHECK(std::abs(found.fy / expected.fy - 1.0) < 5e-4);
    CHECK(std::abs(found.coeffs[0] - expected.coeffs[0]) < 5e-4);
    CHECK(so3_log(truth.T_B_C0.q.conjugate() * refined.rig.T_B_C0.q).norm() < 6e-4);
    CHECK(std::abs(refined.time_shift_s - time_offset_s) < 2e-4);
    CHECK(result.pixel_sigma == Approx(kPixelSigma).epsilon(0.2));

    // Errors are as large as the standard deviations say.
    RigVector error = RigVector::Zero();
    const auto lens_error = [](const CameraIntrinsics& a, const CameraIntrinsics& b) {
        Eigen::Matrix<double, kBatchLensDim, 1> d;
        d << a.fx / b.fx - 1.0, a.fy / b.fy - 1.0, a.cx - b.cx, a.cy - b.cy, a.coeffs[0] - b.coeffs[0],
            a.coeffs[1] - b.coeffs[1], a.coeffs[2] - b.coeffs[2], a.coeffs[3] - b.coeffs[3];
        return d;
    };
    error.segment<kBatchLensDim>(kBatchLens[0]) = lens_error(found, expected);
    error.segment<kBatchLensDim>(kBatchLens[1]) = lens_error(refined.rig.right.intrinsics(), truth.right.intrinsics());
    error.segment<6>(kBatchMount[0]) = truth.T_B_C0.box_minus_to(refined.rig.T_B_C0);
    error.segment<6>(kBatchMount[1]) = truth.T_B_C1.box_minus_to(refined.rig.T_B_C1);
    error(kBatchTime) = refined.time_shift_s - time_offset_s;
    CHECK(error.cwiseQuotient(result.sigma).squaredNorm() / kBatchDim < 3.0);

    const auto rms = [](const std::vector<SightingResidual>& residuals) {
        double squares = 0.0;
        for (const SightingResidual& r : residuals) {
            squares += r.error_px.squaredNorm();
        }
        return std::sqrt(squares / (2.0 * static_cast<double>(residuals.size())));
    };
    CHECK(rms(result.after) < 0.5 * rms(result.before));
    CHECK(rms(result.after) == Approx(kPixelSigma).epsilon(0.2));
}

TEST_CASE("what a flight does not show stays as given") {
    if (!has_batch_solver()) {
        return;
    }
    // A prior as narrow as nothing else could be: the flight adds nothing to it.
    BatchOptions options = wrong_by(1.0, 6);
    options.prior_sigma.segment<3>(kBatchMount[0] + 3).setConstant(1e-6);
    BatchResult result;
    REQUIRE(ok(solve_batch(fly(6.0, 0.0), options, result)));
    CHECK(result.correction.segment<3>(kBatchMount[0] + 3).isZero());
    const std::vector<RigParameter> parameters =
        describe_parameters(options.given, result.correction, result.sigma, options.prior_sigma);
    const auto place = std::ranges::find(parameters, "cam0.place_x", &RigParameter::name);
    REQUIRE(place != parameters.end());
    CHECK(place->verdict == ParameterVerdict::kNotObservable);
    CHECK(place->refined == place->given);
}

TEST_CASE("a batch without points, or with few keyframes, is refused") {
    if (!has_batch_solver()) {
        return;
    }
    RecordedFlight flight = fly(6.0, 0.0);
    const BatchOptions options = wrong_by(0.0, 1);
    BatchResult result;
    result.keyframes = -1;
    RecordedFlight blind = flight;
    for (RecordedKeyframe& keyframe : blind.keyframes) {
        keyframe.sightings.clear();
    }
    CHECK(solve_batch(blind, options, result) == Status::kDegenerate);
    flight.keyframes.resize(5);
    CHECK(solve_batch(flight, options, result) == Status::kDegenerate);
    CHECK(result.keyframes == -1);
}

TEST_CASE("points are triangulated where they are, and only with parallax") {
    const RigAndTime rig{true_rig(), 0.0};
    const Eigen::Vector3d p_W(5.0, 0.5, -0.3);
    for (const double step_m : {0.3, 0.001}) {
        RecordedFlight flight;
        for (int i = 0; i < 4; ++i) {
            RecordedKeyframe keyframe;
            keyframe.state.p_W_B.y() = step_m * i;
            PointSighting s{.point = 3};
            const Eigen::Vector3d p_B = keyframe.state.T_W_B().inverse() * p_W;
            REQUIRE(ok(rig.rig.left.project(rig.rig.T_B_C0.inverse() * p_B, s.left_px)));
            keyframe.sightings = {s};
            flight.keyframes.push_back(keyframe);
        }
        const BatchPoints points = triangulate_points(flight, rig);
        if (step_m < 0.01) {
            CHECK(points.p_W.empty());
        } else {
            REQUIRE(points.p_W.size() == 1);
            CHECK((points.p_W[0] - p_W).norm() < 1e-6);
            CHECK(points.sightings.size() == 4);
        }
        flight.keyframes.resize(2);
        CHECK(triangulate_points(flight, rig).p_W.empty());
    }
}

TEST_CASE("the sighting's projection is the camera model's, for every lens") {
    for (const Distortion distortion : {Distortion::kNone, Distortion::kRadialTangential, Distortion::kEquidistant}) {
        CameraIntrinsics k = sim::euroc_rig().left.intrinsics();
        k.distortion = distortion;
        k.coeffs = {-0.02, 0.01, 2e-4, -1e-4};
        const CameraModel camera(k);
        const Se3 T_B_C = sim::euroc_rig().T_B_C0;
        SightingCost cost;
        cost.lens = k;
        cost.T_B_C = T_B_C;
        cost.T_W_B = {so3_exp({0.1, 0.2, -0.3}), {1.0, 2.0, 0.5}};
        cost.px.setZero();
        cost.v_W.setZero();
        cost.w_B.setZero();
        const Eigen::Vector3d p_W = cost.T_W_B * (T_B_C * Eigen::Vector3d(0.7, -0.3, 1.5));
        const std::array<double, 8> zero{};
        Eigen::Vector2d predicted;
        REQUIRE(cost(zero.data(), zero.data(), zero.data(), zero.data(), p_W.data(), predicted.data()));
        Eigen::Vector2d expected;
        REQUIRE(ok(camera.project({0.7, -0.3, 1.5}, expected)));
        CHECK((predicted - expected).norm() < 1e-9);
    }
}

}  // namespace
}  // namespace facet::batch_test
