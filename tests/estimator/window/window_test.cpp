// SPDX-License-Identifier: BSD-2-Clause
// The window smoother on synthetic flights: exact data, noise, consistency, marginalization.
#include "estimator/window/window.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <memory>

#include "tests/support/allocation_guard.h"
#include "tests/support/synthetic_flight.h"

namespace facet::window_test {

using facet::test::SyntheticFlight;

namespace {

using StateMatrix = Eigen::Matrix<double, kStateDim, kStateDim>;
using StateVector = Eigen::Matrix<double, kStateDim, 1>;

struct Run {
    double rmse_m = 0.0;  ///< of the newest keyframe's position, over all keyframes, no alignment
    double last_error_m = 0.0;
    double tilt_error_rad = 0.0;
    double nees_last = 0.0;     ///< of the last keyframe's pose alone
    double nees_pose = 0.0;     ///< mean over keyframes of the newest keyframe's pose, 6 degrees of freedom
    double chi2_per_row = 0.0;  ///< of a sigma of 0.5 px
    double sigma_px = 0.0;      ///< that weights have at the end
    double scale_px = 0.0;      ///< of the loss
    VisionResiduals residuals;  ///< of keyframes that left
    NavState last;
    int keyframes = 0;
};

Run fly(SyntheticFlight::Options options, double sigma_px, double duration_s, int window, bool perturb,
        bool learn_noise = false) {
    SyntheticFlight flight(options);
    const ImuNoise noise = test::euroc_like_noise();
    WindowConfig config;
    config.keyframes = window;
    config.pixel_sigma_px = sigma_px;
    config.learn_pixel_sigma = learn_noise;
    const auto smoother = std::make_unique<Window>();
    smoother->configure(config, {}, flight.rig(), noise);
    NavState start = flight.state(0.0);
    start.bias = {};
    std::mt19937 generator(options.seed + 100);
    std::normal_distribution<double> normal;
    if (perturb) {
        StateVector d;
        for (int i = 0; i < 9; ++i) {
            d(i) = test::start_sigmas()(i) * normal(generator);
        }
        d.tail<6>().setZero();
        start = start.box_plus(d);
    }
    const StateMatrix information = test::start_sigmas().cwiseAbs2().cwiseInverse().asDiagonal();
    const auto first = flight.observe(0.0);
    smoother->start({test::at(0.0), Eigen::Vector3d::Zero(), false, {first.data(), first.size()}}, start, information);
    Run run;
    double sum = 0.0;
    constexpr double kStep = 0.2;
    for (double t = kStep; t <= duration_s + 1e-9; t += kStep) {
        const Preintegration p = flight.preintegrate(t - kStep, t, smoother->newest().state.bias, noise);
        const auto observations = flight.observe(t);
        REQUIRE(ok(smoother->add_keyframe(
            {test::at(t), flight.rate(t), false, {observations.data(), observations.size()}}, p)));
        const WindowSummary summary = smoother->optimize();
        REQUIRE_FALSE(summary.solver.solver_failed);
        REQUIRE_FALSE(summary.marginalization_failed);
        const NavState truth = flight.state(t);
        const NavState& estimate = smoother->newest().state;
        const double error = (estimate.p_W_B - truth.p_W_B).norm();
        sum += error * error;
        run.last_error_m = error;
        run.last = estimate;
        const StateVector d = estimate.box_minus_to(truth);
        StateMatrix covariance;
        REQUIRE(ok(smoother->newest_covariance(covariance)));
        run.nees_last = d.head<6>().dot(covariance.topLeftCorner<6, 6>().inverse() * d.head<6>());
        run.nees_pose += run.nees_last;
        run.chi2_per_row = summary.fit.vision_squared_error_px2 / (0.25 * summary.fit.vision_rows);
        ++run.keyframes;
    }
    run.residuals = smoother->residuals();
    run.sigma_px = smoother->cameras().noise().sigma_px();
    run.scale_px = smoother->cameras().noise().scale_px();
    run.rmse_m = std::sqrt(sum / run.keyframes);
    run.nees_pose /= run.keyframes;
    const Eigen::Vector3d up = run.last.q_W_B.conjugate() * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d up_true = flight.state(duration_s).q_W_B.conjugate() * Eigen::Vector3d::UnitZ();
    run.tilt_error_rad = up.cross(up_true).norm();
    return run;
}

}  // namespace

TEST_CASE("exact measurements keep the window on the true path", "[window]") {
    const Run run = fly({}, 1.0, 8.0, 10, false);
    CHECK(run.rmse_m < 2e-4);  // the integration error of 200 Hz samples
    CHECK(run.tilt_error_rad < 1e-4);
}

TEST_CASE("a wrong start, biases and noise are worked out by the window", "[window]") {
    SyntheticFlight::Options options;
    options.gyro_noise = 1.7e-4;
    options.accel_noise = 2e-3;
    options.pixel_sigma = 0.5;
    options.bias.gyro = {0.005, -0.008, 0.006};
    options.bias.accel = {0.03, -0.04, 0.02};
    const Run run = fly(options, 0.5, 15.0, 15, true);
    CHECK(run.rmse_m < 0.02);
    CHECK(run.chi2_per_row == Approx(1.0).margin(0.25));
    CHECK((run.last.bias.gyro - options.bias.gyro).norm() < 1e-3);
    CHECK((run.last.bias.accel - options.bias.accel).norm() < 0.02);
}

TEST_CASE("a flight under another gravity is as good if that is known; if not, it shows as a bias", "[window]") {
    SyntheticFlight::Options options;
    options.gyro_noise = 1.7e-4;
    options.accel_noise = 2e-3;
    options.pixel_sigma = 0.5;
    const Run usual = fly(options, 0.5, 15.0, 15, true);
    options.gravity_m_per_s2 = options.believed_gravity_m_per_s2 = 9.78;
    const Run known = fly(options, 0.5, 15.0, 15, true);
    options.believed_gravity_m_per_s2 = 9.81;
    const Run wrong = fly(options, 0.5, 15.0, 15, true);
    CHECK(known.rmse_m == Approx(usual.rmse_m).epsilon(0.02));
    CHECK(known.nees_pose == Approx(usual.nees_pose).epsilon(0.02));
    CHECK(known.last.bias.accel.norm() < 0.02);
    const Eigen::Vector3d up_B = wrong.last.q_W_B.conjugate() * Eigen::Vector3d::UnitZ();
    CHECK(up_B.dot(wrong.last.bias.accel - known.last.bias.accel) == Approx(-0.03).margin(0.006));
}

TEST_CASE("the window learns how precise observations are", "[window]") {
    SyntheticFlight::Options options;
    options.gyro_noise = 1.7e-4;
    options.accel_noise = 2e-3;
    options.pixel_sigma = GENERATE(0.25, 0.5);
    const Run run = fly(options, 0.5, 12.0, 10, true, true);
    CHECK(run.scale_px == Approx(options.pixel_sigma).epsilon(0.1));
    // Of normal residuals under Cauchy's loss at one sigma: E[rho'] = 0.461, E[psi^2] = 0.0961, E[psi'] = 0.269.
    CHECK(run.sigma_px == Approx(std::sqrt(0.611 * VisionNoise::kDependence) * options.pixel_sigma).epsilon(0.1));
    // What a landmark's place takes from its own residuals is missing from their deviation.
    for (const ResidualHistogram* h : {&run.residuals.left_u, &run.residuals.right_v}) {
        CHECK(h->total() > 1000);
        CHECK(std::abs(h->mean_px()) < 0.05 * options.pixel_sigma);
        CHECK(h->deviation_px() > 0.8 * options.pixel_sigma);
        CHECK(h->deviation_px() < 1.05 * options.pixel_sigma);
    }
    CHECK(run.rmse_m < 0.02);
}

TEST_CASE("a start in motion with gravity far off is worked out within a second", "[window]") {
    SyntheticFlight::Options options;
    options.gyro_noise = 1.7e-4;
    options.accel_noise = 2e-3;
    options.pixel_sigma = 0.5;
    SyntheticFlight flight(options);
    const ImuNoise noise = test::euroc_like_noise();
    WindowConfig config;
    config.pixel_sigma_px = 0.5;
    const auto smoother = std::make_unique<Window>();
    smoother->configure(config, {}, flight.rig(), noise);
    NavState start = flight.state(0.0);
    const Eigen::Vector3d tilt_error(0.15, -0.12, 0.0);  // 11 degrees
    start.q_W_B = start.q_W_B * so3_exp(start.q_W_B.conjugate() * tilt_error);
    start.v_W_B.setZero();  // truly 1 m/s
    StateVector sigma = test::start_sigmas();
    sigma.segment<3>(kVel).setConstant(2.0);
    const Eigen::Matrix3d R = start.q_W_B.toRotationMatrix();
    StateMatrix information = sigma.cwiseAbs2().cwiseInverse().asDiagonal();
    information.topLeftCorner<3, 3>() = R.transpose() * Eigen::Vector3d(25.0, 25.0, 1e8).asDiagonal() * R;
    const auto first = flight.observe(0.0);
    smoother->start({test::at(0.0), Eigen::Vector3d::Zero(), false, {first.data(), first.size()}}, start, information);
    for (int k = 1; k <= 6; ++k) {
        const double t = 0.2 * k;
        const Preintegration p = flight.preintegrate(t - 0.2, t, smoother->newest().state.bias, noise);
        const auto observations = flight.observe(t);
        REQUIRE(ok(smoother->add_keyframe(
            {test::at(t), flight.rate(t), false, {observations.data(), observations.size()}}, p)));
        REQUIRE_FALSE(smoother->optimize().solver.solver_failed);
    }
    const NavState truth = flight.state(1.2);
    const NavState& estimate = smoother->newest().state;
    const Eigen::Vector3d up = estimate.q_W_B.conjugate() * Eigen::Vector3d::UnitZ();
    CHECK(up.cross(truth.q_W_B.conjugate() * Eigen::Vector3d::UnitZ()).norm() < 0.02);
    // Yaw is the gauge: compare speeds in the body.
    CHECK((estimate.q_W_B.conjugate() * estimate.v_W_B - truth.q_W_B.conjugate() * truth.v_W_B).norm() < 0.05);
}

TEST_CASE("the window finds the cameras' time offset and rotation", "[window]") {
    SyntheticFlight::Options options;
    options.gyro_noise = 1.7e-4;
    options.accel_noise = 2e-3;
    options.pixel_sigma = 0.3;  // as on real images
    const bool turned = GENERATE(false, true);
    options.time_offset_s = turned ? 0.0 : 0.005;
    options.rig_rotation = turned ? Eigen::Vector3d(0.006, -0.005, 0.004) : Eigen::Vector3d::Zero();  // 0.5 degrees
    SyntheticFlight flight(options);
    const ImuNoise noise = test::euroc_like_noise();
    WindowConfig config;
    CalibrationConfig calibration;
    calibration.estimate_extrinsics = turned;
    const auto smoother = std::make_unique<Window>();
    smoother->configure(config, calibration, flight.rig(), noise);
    const StateMatrix information = test::start_sigmas().cwiseAbs2().cwiseInverse().asDiagonal();
    double before = 0.0;  // IMU time of the last keyframe
    for (int k = 0; k <= 100; ++k) {
        const double t = 0.2 * k + smoother->calibration().time_offset_s;
        const auto seen = flight.observe(0.2 * k);
        const KeyframeInput input{test::at(t), flight.rate(t), false, {seen.data(), seen.size()}};
        if (k == 0) {
            smoother->start(input, flight.state(t), information);
        } else {
            const Preintegration p = flight.preintegrate(before, t, smoother->newest().state.bias, noise);
            REQUIRE(ok(smoother->add_keyframe(input, p)));
            REQUIRE_FALSE(smoother->optimize().solver.solver_failed);
        }
        before = t;
    }
    StateMatrix covariance;
    REQUIRE(ok(smoother->newest_covariance(covariance)));
    const RigCalibration& found = smoother->calibration();
    const double time_error = found.time_offset_s - options.time_offset_s;
    CHECK(std::abs(time_error) < 0.5e-3);
    CHECK(std::abs(time_error) < 4.0 * smoother->calibration_sigma(kTimeOffset));
    const Eigen::Vector3d turn_error = so3_log(found.T_B_Bc.q) - options.rig_rotation;
    CHECK(turn_error.norm() < 0.0017);  // 0.1 degrees
    for (int i = 0; turned && i < 3; ++i) {
        CHECK(std::abs(turn_error(i)) < 4.0 * smoother->calibration_sigma(kRigTheta + i));
    }
}

namespace {

/// What the window makes of cameras whose principal points and right mount are not as given.
struct CamerasFound {
    RigCalibration calibration;
    double sigma_principal_px = 0.0;  ///< of the left camera's, horizontal
    double sigma_focal = 0.0;         ///< of the left camera's, horizontal
    double scale = 1.0;               ///< of the given standard deviations, as learnt
};

/// @param moving  false: the first instant of the flight again and again, at rest
CamerasFound find_cameras(const Eigen::Vector2d& left_px, const Eigen::Vector2d& right_px, bool moving) {
    SyntheticFlight::Options options;
    options.gyro_noise = 1.7e-4;
    options.accel_noise = 2e-3;
    options.pixel_sigma = 0.2;
    SyntheticFlight flight(options);
    const ImuNoise noise = test::euroc_like_noise();
    WindowConfig config;
    config.keyframes = 12;
    config.pixel_sigma_px = 0.2;
    const auto smoother = std::make_unique<Window>();
    smoother->configure(config, {}, flight.rig(), noise);
    const StateMatrix information = test::start_sigmas().cwiseAbs2().cwiseInverse().asDiagonal();
    NavState start = flight.state(0.0);
    ImuSample force;
    if (!moving) {
        start.v_W_B.setZero();
        force.a_B = start.q_W_B.conjugate() * Eigen::Vector3d(0.0, 0.0, 9.81);
    }
    for (int k = 0; k <= (moving ? 150 : 30); ++k) {
        const double t = 0.2 * k;
        auto seen = flight.observe(moving ? t : 0.0);
        for (FeatureObservation& o : seen) {  // a principal point that is farther right is given as too far left
            o.left_xy += left_px / flight.rig().left.focal_px();
            o.right_xy += right_px / flight.rig().right.focal_px();
        }
        const Eigen::Vector3d rate = moving ? flight.rate(t) : Eigen::Vector3d::Zero();
        const KeyframeInput input{test::at(t), rate, !moving && k > 0, {seen.data(), seen.size()}};
        if (k == 0) {
            smoother->start(input, start, information);
            continue;
        }
        Preintegration p(smoother->newest().state.bias);
        if (moving) {
            p = flight.preintegrate(t - 0.2, t, smoother->newest().state.bias, noise);
        } else {
            ImuSample after = force;
            force.stamp = test::at(t - 0.2);
            after.stamp = test::at(t);
            REQUIRE(ok(p.integrate(force, after, noise)));
        }
        REQUIRE(ok(smoother->add_keyframe(input, p)));
        REQUIRE_FALSE(smoother->optimize().solver.solver_failed);
    }
    StateMatrix covariance;
    REQUIRE(ok(smoother->newest_covariance(covariance)));
    return {smoother->calibration(), smoother->calibration_sigma(kLeftLens + 2), smoother->calibration_sigma(kLeftLens),
            smoother->calibration_scale()};
}

}  // namespace

TEST_CASE("principal points are found in lively flight", "[window]") {
    const Eigen::Vector2d left(0.5, -0.3);
    const Eigen::Vector2d right(-0.2, 0.4);
    const CamerasFound found = find_cameras(left, right, true);
    INFO("left " << found.calibration.lens[0].transpose() << ", right " << found.calibration.lens[1].transpose());
    CHECK((found.calibration.lens[0].segment<2>(2) - left).norm() < 0.15);
    CHECK((found.calibration.lens[1].segment<2>(2) - right).norm() < 0.15);
    CHECK(found.sigma_principal_px < 0.5 * CalibrationConfig{}.principal_sigma_px);
}

TEST_CASE("what standing does not reveal of the cameras stays as given", "[window]") {
    const CamerasFound found = find_cameras({0.0, 0.0}, {0.0, 0.0}, false);
    const CalibrationConfig config;
    INFO("left " << found.calibration.lens[0].transpose() << ", right " << found.calibration.lens[1].transpose());
    CHECK(found.calibration.lens[0].segment<2>(2).norm() < config.principal_sigma_px);
    // What one view shows of the cameras is right here, and speaks for the rest.
    CHECK(found.scale > 0.3);
    CHECK(found.scale < 1.0);
    CHECK(found.sigma_principal_px > 0.5 * found.scale * config.principal_sigma_px);
    CHECK(found.sigma_focal > 0.5 * found.scale * config.focal_sigma);
    CHECK(found.sigma_focal < 1.001 * config.focal_sigma);
}

TEST_CASE("the window allocates nothing once it exists", "[window]") {
    SyntheticFlight::Options options;
    options.pixel_sigma = 0.5;
    SyntheticFlight flight(options);
    const ImuNoise noise = test::euroc_like_noise();
    WindowConfig config;
    config.keyframes = 6;
    const auto smoother = std::make_unique<Window>();
    smoother->configure(config, {}, flight.rig(), noise);
    const auto first = flight.observe(0.0);
    const StateMatrix information = test::start_sigmas().cwiseAbs2().cwiseInverse().asDiagonal();
    std::uint64_t allocations = 0;
    {
        const test::AllocationGuard guard;
        smoother->start({test::at(0.0), Eigen::Vector3d::Zero(), false, {first.data(), first.size()}},
                        flight.state(0.0), information);
        allocations += guard.allocations();
    }
    for (int k = 1; k <= 12; ++k) {  // twice the window: marginalization included
        const double t = 0.2 * k;
        const Preintegration p = flight.preintegrate(t - 0.2, t, smoother->newest().state.bias, noise);
        const auto observations = flight.observe(t);
        StateMatrix covariance;
        const test::AllocationGuard guard;
        const Status added =
            smoother->add_keyframe({test::at(t), flight.rate(t), false, {observations.data(), observations.size()}}, p);
        const WindowSummary summary = smoother->optimize();
        const Status known = smoother->newest_covariance(covariance);
        const double doubt = smoother->cameras_covariance().trace();
        allocations += guard.allocations();
        REQUIRE(ok(added));
        REQUIRE(ok(known));
        REQUIRE(doubt > 0.0);
        REQUIRE(summary.fit.active_landmarks > 0);
    }
    CHECK(allocations == 0);
}

TEST_CASE("Monte Carlo: the newest pose is as uncertain as the window says", "[window]") {
    double nees = 0.0;
    double nees_last = 0.0;
    constexpr int kRuns = 24;
    constexpr double kWeightSigma = 0.35;  // px: for independent errors; VisionNoise expects dependent ones: 0.65
    for (int i = 0; i < kRuns; ++i) {
        SyntheticFlight::Options options;
        options.gyro_noise = 1.7e-4;
        options.accel_noise = 2e-3;
        options.pixel_sigma = 0.5;
        options.seed = 10U + static_cast<unsigned>(i);
        const Run run = fly(options, kWeightSigma, 6.0, 8, true);
        nees += run.nees_pose / kRuns;
        nees_last += run.nees_last / kRuns;
    }
    INFO("mean pose NEES " << nees << ", at the end " << nees_last << ", expected 6");
    // 95 % of chi^2 with 6 x 24 degrees of freedom, over 24: runs are independent, keyframes of one run are not.
    CHECK(nees > 4.69);
    CHECK(nees < 7.46);
    CHECK(nees_last > 3.5);  // one instant alone: rather cautious than too sure
    CHECK(nees_last < 8.5);
}

}  // namespace facet::window_test
