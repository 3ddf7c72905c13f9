// SPDX-License-Identifier: BSD-2-Clause
// The first state in motion: exact without noise, within its stated uncertainty with it, and refused where it must be.
#include "estimator/imu/dynamic_init.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "tests/support/allocation_guard.h"
#include "tests/support/check_fields.h"

namespace facet {
namespace {

using Vector15 = Eigen::Matrix<double, 15, 1>;

/// Position and rotation vector as sums of sines; derivatives of the position analytic, the rate by differences.
struct Flight {
    Eigen::Vector3d p_amplitude{0.4, 0.3, 0.2};
    Eigen::Vector3d p_rate{2.5, 3.1, 2.2};  ///< rad/s
    Eigen::Vector3d p_phase = Eigen::Vector3d::Zero();
    Eigen::Vector3d theta_amplitude{0.2, 0.15, 0.4};
    Eigen::Vector3d theta_rate{2.1, 2.7, 1.6};
    Eigen::Vector3d theta_phase = Eigen::Vector3d::Zero();
    Eigen::Vector3d v0 = Eigen::Vector3d::Zero();
    Eigen::Vector3d a0 = Eigen::Vector3d::Zero();  ///< constant acceleration
    Eigen::Vector3d theta0 = Eigen::Vector3d::Zero();
    double gravity = 9.81;

    static Eigen::Vector3d wave(const Eigen::Vector3d& a, const Eigen::Vector3d& rate, const Eigen::Vector3d& phase,
                                double t, int derivative) {
        const Eigen::Array3d angle = rate.array() * t + phase.array() + derivative * M_PI / 2.0;
        return a.array() * rate.array().pow(derivative) * angle.sin();
    }
    NavState state(double t) const {
        NavState s;
        s.q_W_B = so3_exp(theta0) * so3_exp(wave(theta_amplitude, theta_rate, theta_phase, t, 0));
        s.p_W_B = wave(p_amplitude, p_rate, p_phase, t, 0) + t * v0 + 0.5 * t * t * a0;
        s.v_W_B = wave(p_amplitude, p_rate, p_phase, t, 1) + v0 + t * a0;
        return s;
    }
    ImuSample sample(double t) const {
        constexpr double kStep = 1e-5;
        ImuSample s;
        s.stamp = Timestamp{Duration::from_seconds(10.0 + t).ns};
        const NavState now = state(t);
        s.w_B = so3_log(state(t - kStep).q_W_B.conjugate() * state(t + kStep).q_W_B) / (2.0 * kStep);
        s.a_B = now.q_W_B.conjugate() * (wave(p_amplitude, p_rate, p_phase, t, 2) + a0 - gravity_W(gravity));
        return s;
    }
};

struct Setup {
    int motions = 4;
    double interval_s = 0.25;
    double rate_hz = 200.0;
    double noise_scale = 1.0;  ///< of IMU and vision; 0 for none
    double p_sigma = 3e-3;
    double theta_sigma = 1e-3;
    bool has_rotation = true;
    double gravity = 9.81;  ///< that the motions are integrated with
    ImuBias bias{};
};

class Generator {
public:
    explicit Generator(unsigned seed) : rng_(seed) {}

    Eigen::Vector3d gaussian(double sigma) {
        return sigma * Eigen::Vector3d(normal_(rng_), normal_(rng_), normal_(rng_));
    }
    Eigen::Vector3d uniform(double low, double high) {
        std::uniform_real_distribution<double> u(low, high);
        return {u(rng_), u(rng_), u(rng_)};
    }
    /// As gentle as the hand-held sequences of EuRoC: up to 0.5 m and 3 rad/s, turned anyhow.
    Flight flight() {
        Flight f;
        f.p_amplitude = uniform(0.1, 0.5);
        f.p_rate = uniform(1.5, 3.5);
        f.p_phase = uniform(0.0, 6.28);
        f.theta_amplitude = uniform(0.1, 0.4);
        f.theta_rate = uniform(1.5, 3.0);
        f.theta_phase = uniform(0.0, 6.28);
        f.v0 = uniform(-1.0, 1.0);
        f.theta0 = uniform(-1.2, 1.2);
        return f;
    }
    std::vector<KeyframeMotion> motions(const Flight& flight, const Setup& setup) {
        const ImuNoise noise;
        std::vector<KeyframeMotion> out;
        const int steps = static_cast<int>(std::lround(setup.interval_s * setup.rate_hz));
        const double root_rate = std::sqrt(setup.rate_hz) * setup.noise_scale;
        const auto measure = [&](double t) {
            ImuSample s = flight.sample(t);
            s.w_B += setup.bias.gyro + gaussian(noise.gyro_noise_rad_per_s_per_sqrt_hz * root_rate);
            s.a_B += setup.bias.accel + gaussian(noise.accel_noise_m_per_s2_per_sqrt_hz * root_rate);
            return s;
        };
        ImuSample last = measure(0.0);
        for (int k = 0; k < setup.motions; ++k) {
            KeyframeMotion m;
            m.imu = Preintegration({}, setup.gravity);
            const double begin = k * setup.interval_s;
            for (int i = 1; i <= steps; ++i) {
                const ImuSample next = measure(begin + i / setup.rate_hz);
                REQUIRE(ok(m.imu.integrate(last, next, noise)));
                last = next;
            }
            const NavState a = flight.state(begin);
            const NavState b = flight.state(begin + setup.interval_s);
            m.p_Bk_Bj = a.q_W_B.conjugate() * (b.p_W_B - a.p_W_B) + gaussian(setup.p_sigma * setup.noise_scale);
            m.p_covariance *= setup.p_sigma * setup.p_sigma;
            m.has_rotation = setup.has_rotation;
            m.q_Bk_Bj = a.q_W_B.conjugate() * b.q_W_B * so3_exp(gaussian(setup.theta_sigma * setup.noise_scale));
            m.theta_covariance *= setup.theta_sigma * setup.theta_sigma;
            out.push_back(m);
        }
        return out;
    }

private:
    std::mt19937 rng_;
    std::normal_distribution<double> normal_;
};

/// Estimate to truth at the last keyframe, in the estimate's W: the truth is turned about the vertical until the
/// rotation error has no part about it, and its origin is the body.
Vector15 error_of(const DynamicInit& result, const Flight& flight, const Setup& setup) {
    NavState truth = flight.state(setup.motions * setup.interval_s);
    truth.p_W_B.setZero();
    truth.bias = setup.bias;
    for (int step = 0; step < 10; ++step) {
        const Eigen::Vector3d d_W =
            result.initial.state.q_W_B * so3_log(result.initial.state.q_W_B.conjugate() * truth.q_W_B);
        const Eigen::Quaterniond turn = so3_exp({0.0, 0.0, -d_W.z()});
        truth.q_W_B = turn * truth.q_W_B;
        truth.v_W_B = turn * truth.v_W_B;
    }
    return result.initial.state.box_minus_to(truth);
}

double tilt_of(const Vector15& error) { return error.head<3>().norm(); }
double velocity_of(const Vector15& error) { return error.segment<3>(kVel).norm(); }

constexpr double kDegree = M_PI / 180.0;

}  // namespace

TEST_CASE("without noise the state is exact, biases included as far as they are seen") {
    Generator generator(1);
    for (int run = 0; run < 20; ++run) {
        const Flight flight = generator.flight();
        Setup setup;
        setup.noise_scale = 0.0;
        setup.rate_hz = 2000.0;
        setup.bias.gyro = {0.004, -0.003, 0.005};
        DynamicInit result;
        REQUIRE(ok(initialize_in_motion(generator.motions(flight, setup), DynamicInitConfig{}, result)));
        const Vector15 error = error_of(result, flight, setup);
        CHECK(tilt_of(error) < 1e-3);
        CHECK(velocity_of(error) < 2e-3);
        CHECK(error.segment<3>(kBiasGyro).norm() < 2e-4);
        CHECK(result.gravity_norm_m_per_s2 == Approx(9.81).margin(0.02));
        CHECK(result.chi2_per_dof < 0.1);
        CHECK_FALSE(result.initial.is_still);
    }
}

TEST_CASE("the start imposes the gravity that it is given, and refuses another") {
    Generator generator(1);
    Flight flight = generator.flight();
    flight.gravity = 7.0;
    Setup setup;
    setup.noise_scale = 0.0;
    setup.rate_hz = 2000.0;
    DynamicInit result;
    CHECK(initialize_in_motion(generator.motions(flight, setup), DynamicInitConfig{}, result) == Status::kCorrupt);
    setup.gravity = 7.0;
    REQUIRE(ok(initialize_in_motion(generator.motions(flight, setup), DynamicInitConfig{}, result)));
    const Vector15 error = error_of(result, flight, setup);
    CHECK(tilt_of(error) < 5e-3);
    CHECK(velocity_of(error) < 2e-3);
    CHECK(result.gravity_norm_m_per_s2 == Approx(7.0).margin(0.02));
}

TEST_CASE("one second of gentle motion gives the tilt to about a degree and the velocity to 5 cm/s") {
    for (const bool has_rotation : {true, false}) {
        CAPTURE(has_rotation);
        Generator generator(2);
        for (int run = 0; run < 100; ++run) {
            const Flight flight = generator.flight();
            Setup setup;
            setup.has_rotation = has_rotation;
            DynamicInitConfig config;
            // unless vision sees it, the gyro bias must be known from before
            const double gyro_sigma = has_rotation ? 0.05 : 0.003;
            config.gyro_bias_sigma_rad_per_s = gyro_sigma;
            setup.bias.gyro = generator.gaussian(gyro_sigma);
            setup.bias.accel = generator.gaussian(0.04);
            DynamicInit result;
            REQUIRE(ok(initialize_in_motion(generator.motions(flight, setup), config, result)));
            const Vector15 error = error_of(result, flight, setup);
            CHECK(tilt_of(error) < 1.2 * kDegree);
            CHECK(velocity_of(error) < 0.05);
        }
    }
}

TEST_CASE("errors are of the size the information says") {
    for (const bool has_rotation : {true, false}) {
        CAPTURE(has_rotation);
        Generator generator(3);
        constexpr int kRuns = 200;
        constexpr double kDimension = 11.0;  // tilt 2, velocity 3, biases 6
        double nees = 0.0;
        double chi2 = 0.0;
        for (int run = 0; run < kRuns; ++run) {
            const Flight flight = generator.flight();
            Setup setup;
            setup.has_rotation = has_rotation;
            setup.motions = 3 + run % 6;
            DynamicInitConfig config;
            config.gyro_bias_sigma_rad_per_s = has_rotation ? 0.02 : 0.005;
            config.max_velocity_sigma_m_per_s = 1.0;
            setup.bias.gyro = generator.gaussian(config.gyro_bias_sigma_rad_per_s);
            setup.bias.accel = generator.gaussian(config.accel_bias_sigma_m_per_s2);
            DynamicInit result;
            REQUIRE(ok(initialize_in_motion(generator.motions(flight, setup), config, result)));
            const Vector15 error = error_of(result, flight, setup);
            nees += (result.initial.sqrt_information * error).squaredNorm() / (kDimension * kRuns);
            chi2 += result.chi2_per_dof / kRuns;
            CHECK(velocity_of(error) < 5.0 * result.velocity_sigma_m_per_s + 2.0 * tilt_of(error));
        }
        CHECK(nees < 1.25);
        CHECK(nees > 0.75);
        CHECK(chi2 == Approx(1.0).margin(0.2));
    }
}

TEST_CASE("standing still, constant velocity, constant acceleration and free fall are no special cases") {
    Flight rest;
    rest.p_amplitude.setZero();
    rest.theta_amplitude.setZero();
    rest.theta0 = {0.3, -0.5, 1.0};
    Flight glide = rest;
    glide.v0 = {2.0, -1.0, 0.5};
    Flight climb = glide;
    climb.a0 = {1.0, 0.5, 2.0};
    Flight fall = rest;
    fall.a0 = gravity_W(9.81);
    Generator generator(4);
    for (const Flight& flight : {rest, glide, climb, fall}) {
        Setup setup;
        setup.motions = 8;
        setup.bias.gyro = generator.gaussian(0.003);
        setup.bias.accel = generator.gaussian(0.04);
        DynamicInitConfig config;
        config.gyro_bias_sigma_rad_per_s = 0.01;
        DynamicInit result;
        const Status status = initialize_in_motion(generator.motions(flight, setup), config, result);
        CAPTURE(flight.v0.transpose(), flight.a0.transpose(), to_string(status));
        REQUIRE(ok(status));
        const Vector15 error = error_of(result, flight, setup);
        CHECK(tilt_of(error) < 1.2 * kDegree);
        // a fast body's velocity turns with the tilt
        CHECK(velocity_of(error) < 0.05 + tilt_of(error) * result.initial.state.v_W_B.norm());
    }
}

TEST_CASE("too short or too coarse vision is degenerate, contradicting data corrupt, too little invalid") {
    Generator generator(5);
    const Flight flight = generator.flight();
    DynamicInit result;
    result.chi2_per_dof = -1.0;
    Setup brief;
    brief.motions = 2;
    brief.interval_s = 0.02;
    CHECK(initialize_in_motion(generator.motions(flight, brief), {}, result) == Status::kDegenerate);
    Setup coarse;
    coarse.p_sigma = 0.5;
    CHECK(initialize_in_motion(generator.motions(flight, coarse), {}, result) == Status::kDegenerate);
    auto broken = generator.motions(flight, {});
    broken[2].p_covariance *= std::nan("");
    CHECK(initialize_in_motion(broken, {}, result) == Status::kDegenerate);
    // vision at half the scale: gravity comes out wrong, or the rest disagrees
    auto half = generator.motions(flight, Setup{.motions = 8});
    for (KeyframeMotion& m : half) {
        m.p_Bk_Bj *= 0.5;
    }
    CHECK(initialize_in_motion(half, {}, result) == Status::kCorrupt);
    auto jump = generator.motions(flight, {});
    jump[1].p_Bk_Bj.x() += 0.5;
    CHECK(initialize_in_motion(jump, {}, result) == Status::kCorrupt);

    const auto whole = generator.motions(flight, Setup{.motions = 12});
    CHECK(initialize_in_motion({whole.data(), 1}, {}, result) == Status::kInvalidArgument);
    CHECK(initialize_in_motion({}, {}, result) == Status::kInvalidArgument);
    CHECK(initialize_in_motion(whole, {}, result) == Status::kInvalidArgument);
    auto empty = whole;
    empty[0].imu.reset({});
    CHECK(initialize_in_motion({empty.data(), 4}, {}, result) == Status::kInvalidArgument);
    CHECK(result.chi2_per_dof == -1.0);
    CHECK(ok(initialize_in_motion({whole.data(), 11}, {}, result)));
}

TEST_CASE("initialization in motion does not allocate") {
    Generator generator(6);
    const auto motions = generator.motions(generator.flight(), Setup{.motions = 11});
    DynamicInit result;
    test::AllocationGuard guard;
    const Status status = initialize_in_motion(motions, {}, result);
    const std::uint64_t allocations = guard.allocations();
    CHECK(ok(status));
    CHECK(allocations == 0);
}

TEST_CASE("the config of the initialization in motion is validated field by field") {
    test::check_fields(kDynamicInitFields);
}

}  // namespace facet
