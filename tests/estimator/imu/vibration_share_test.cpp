// SPDX-License-Identifier: BSD-2-Clause
// How much of the vibration accumulates: learnt from inertial factors, and what a factor's covariance makes of it.
#include "estimator/imu/vibration_share.h"

#include <Eigen/Cholesky>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>

#include "estimator/imu/imu_buffer.h"

namespace facet::vibration_share_test {
namespace {

using Matrix9 = Eigen::Matrix<double, 9, 9>;
using Vector9 = Eigen::Matrix<double, 9, 1>;

/// Learns from factors of 0.25 s whose true noise has these shares, beside images whose errors in each row have the
/// variance `images` (that of the noise at share 1 is 1).
VibrationShare learnt(const VibrationShare& truth, double images, int factors, unsigned seed) {
    std::mt19937 rng(seed);
    std::normal_distribution<double> normal;
    VibrationLearner learner;
    InertialInnovation innovation;
    innovation.dt_s = 0.25;
    for (int k = 0; k < factors; ++k) {
        const VibrationShare now = learner.share();
        innovation.covariance.setZero();
        for (int row = 0; row < 9; ++row) {
            // Two measurements of one quantity: what one leaves of the other, whitened as stated.
            const double stated = row < 3 ? now.gyro : now.accel;
            const double noise = row < 3 ? truth.gyro : truth.accel;
            const double left = stated / (stated + images);
            innovation.r(row) = left * std::sqrt((noise + images) / stated) * normal(rng);
            innovation.covariance(row, row) = left;
        }
        learner.learn_gyro(innovation);
        learner.learn_accel(innovation);
    }
    return learner.share();
}

/// A body at rest whose sensors hear many tones, half of them in either band of the meter.
class Humming {
public:
    explicit Humming(unsigned seed) : rng_(seed) {
        for (Tone& tone : tones_) {
            const bool is_high = (&tone - tones_.data()) % 2 == 0;
            tone.hz = is_high ? 65.0 + 34.0 * uniform_(rng_) : 20.0 + 30.0 * uniform_(rng_);
            tone.phase = Eigen::Array3d(uniform_(rng_), uniform_(rng_), uniform_(rng_));
        }
    }
    ImuSample sample(double t) const {
        Eigen::Array3d sum = Eigen::Array3d::Zero();
        for (const Tone& tone : tones_) {
            sum += (2.0 * std::numbers::pi * (tone.hz * t + tone.phase)).sin() * std::sqrt(2.0 / tones_.size());
        }
        ImuSample s;
        s.stamp = Timestamp{Duration::from_seconds(t).ns};
        s.a_B = Eigen::Vector3d(0.0, 0.0, 9.81) + sum.matrix();
        return s;
    }

private:
    struct Tone {
        double hz = 0.0;
        Eigen::Array3d phase;
    };
    std::mt19937 rng_;
    std::uniform_real_distribution<double> uniform_;
    std::array<Tone, 24> tones_;
};

/// Mean over runs of the squared error of delta v over its variance, and of the standard deviation stated (m/s).
struct VelocityError {
    double nees = 0.0;
    double sigma = 0.0;
};
VelocityError velocity_error(const VibrationShare& share, double interval_s) {
    constexpr int kRuns = 60;
    VelocityError out;
    for (unsigned run = 0; run < kRuns; ++run) {
        const Humming body(run);
        const auto buffer = std::make_unique<ImuBuffer>(200.0);
        buffer->believe(share);
        for (int k = 0; k <= 500; ++k) {
            REQUIRE(ok(buffer->push(body.sample(k / 200.0))));
        }
        Preintegration pre;
        REQUIRE(ok(buffer->integrate_between(Timestamp{} + Duration::from_seconds(1.0),
                                             Timestamp{} + Duration::from_seconds(1.0 + interval_s), ImuNoise{}, pre)));
        const Eigen::Vector3d error = pre.delta_v() - Eigen::Vector3d(0.0, 0.0, 9.81 * interval_s);
        Eigen::Matrix3d covariance = pre.covariance().block<3, 3>(kVel, kVel);
        covariance += 2.0 * buffer->velocity_ripple().asDiagonal().toDenseMatrix();
        out.nees += error.dot(covariance.llt().solve(error)) / 3.0 / kRuns;
        out.sigma += std::sqrt(covariance.trace() / 3.0) / kRuns;
    }
    return out;
}

}  // namespace

TEST_CASE("the share is found from either side, by good images and by poor ones") {
    for (const double images : {0.003, 0.03}) {
        for (const double gyro : {0.02, 0.1, 1.0}) {
            const double accel = 0.02 / gyro;
            constexpr unsigned kDraws = 12;
            double gyro_error = 0.0;
            double accel_error = 0.0;
            for (unsigned seed = 1; seed <= kDraws; ++seed) {
                const VibrationShare share = learnt({gyro, accel}, images, 300, seed);
                gyro_error += std::log(share.gyro / gyro) / kDraws;
                accel_error += std::log(share.accel / accel) / kDraws;
            }
            CAPTURE(images, gyro, gyro_error, accel_error);
            CHECK(std::abs(gyro_error) < 0.4);
            CHECK(std::abs(accel_error) < 0.4);
        }
    }
}

TEST_CASE("ten seconds are enough, one blunder is not") {
    CHECK(learnt({0.05, 0.05}, 0.01, 40, 3).accel < 0.1);
    InertialInnovation blunder;
    blunder.dt_s = 0.25;
    blunder.r.setConstant(1e6);
    blunder.covariance.setIdentity();
    VibrationLearner learner;
    learner.learn_accel(blunder);
    CHECK(learner.share().accel < 2.1);
    CHECK(learner.share().gyro == VibrationLearner{}.share().gyro);
    blunder.r.setConstant(std::nan(""));
    learner.reset();
    learner.learn_gyro(blunder);
    CHECK(learner.share().gyro == VibrationLearner{}.share().gyro);
}

TEST_CASE("tones that do not accumulate leave an error at the ends, whatever the interval") {
    for (const double interval_s : {0.1, 0.3, 1.0}) {
        CAPTURE(interval_s);
        const VelocityError all = velocity_error({1.0, 1.0}, interval_s);
        const VelocityError none = velocity_error({0.0025, 0.0025}, interval_s);
        CHECK(all.nees < 0.5);
        CHECK(none.nees < 1.3);
        CHECK(none.nees > 0.1);
        CHECK(none.sigma < 0.012);
    }
}

}  // namespace facet::vibration_share_test
