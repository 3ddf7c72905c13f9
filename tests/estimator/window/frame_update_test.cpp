// SPDX-License-Identifier: BSD-2-Clause
// Frames between keyframes: Jacobians, honest covariance, outliers, and what is done without landmarks.
#include "estimator/window/frame_update.h"

#include <Eigen/LU>
#include <array>
#include <catch2/catch.hpp>
#include <memory>
#include <random>

#include "estimator/window/window.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/numeric_jacobian.h"
#include "tests/support/synthetic_flight.h"

namespace facet::frame_update_test {

using facet::test::SyntheticFlight;

namespace {

using StateMatrix = Eigen::Matrix<double, kStateDim, kStateDim>;
using StateVector = Eigen::Matrix<double, kStateDim, 1>;
using PoseVector = Eigen::Matrix<double, kPoseDim, 1>;

constexpr double kPixelSigma = 0.3;  // of one observation
constexpr double kKeyframeStep_s = 0.25;
constexpr int kKeyframes = 8;
constexpr int kLandmarks = 800;  // on all sides: a tenth of them is seen
constexpr double kNewest_s = kKeyframeStep_s * (kKeyframes - 1);

StateVector error_of(const NavState& estimate, const NavState& truth) { return estimate.box_minus_to(truth); }

/// A window after a flight whose tracks err as a first-order Markov process, as FrameUpdate takes them to.
class Flight {
public:
    explicit Flight(unsigned seed) : flight_(options(seed)), noise_(test::euroc_like_noise()), generator_(seed + 50) {
        // Of a vibrating vehicle: the prediction from keyframe to frame is far worse than the images.
        noise_.accel_noise_m_per_s2_per_sqrt_hz = options(seed).accel_noise;
        noise_.gyro_noise_rad_per_s_per_sqrt_hz = options(seed).gyro_noise;
        WindowConfig config;
        config.keyframes = 12;
        config.pixel_sigma_px = kPixelSigma * std::sqrt(VisionNoise::kDependence);
        config.learn_pixel_sigma = false;
        window->configure(config, {}, flight_.rig(), noise_);
        StateVector sigma = test::start_sigmas();
        NavState start = flight_.state(0.0);
        for (int i = 0; i < kStateDim; ++i) {
            const double d = sigma(i) * normal_(generator_);
            start = start.box_plus(d * StateVector::Unit(i));
        }
        for (int k = 0; k < kKeyframes; ++k) {
            const double t = kKeyframeStep_s * k;
            const auto seen = observe(t);
            const KeyframeInput input{test::at(t), flight_.rate(t), false, {seen.data(), seen.size()}};
            if (k == 0) {
                window->start(input, start, sigma.cwiseAbs2().cwiseInverse().asDiagonal());
                continue;
            }
            const ImuBias bias = window->newest().state.bias;
            REQUIRE(ok(window->add_keyframe(input, flight_.preintegrate(t - kKeyframeStep_s, t, bias, noise_))));
            REQUIRE_FALSE(window->optimize(k == 1 ? 5.0 : 1.0).solver.solver_failed);
        }
        REQUIRE(ok(window->newest_covariance(covariance)));
        REQUIRE(ok(window->fill_map(*map)));
    }

    /// What the cameras see, with the tracks' errors.
    std::vector<FeatureObservation> observe(double t) {
        auto seen = flight_.observe(t, 200);
        const double focal = flight_.rig().left.focal_px();
        for (FeatureObservation& o : seen) {
            Track& track = tracks_[o.landmark.value];
            const double a = track.is_known ? TrackMemory::after(t - track.t).correlation : 0.0;
            for (int i = 0; i < 4; ++i) {
                track.error(i) = a * track.error(i) + std::sqrt(1.0 - a * a) * kPixelSigma * normal_(generator_);
            }
            track.t = t;
            track.is_known = true;
            o.left_xy += track.error.head<2>() / focal;
            o.right_xy += track.error.tail<2>() / focal;
        }
        return seen;
    }

    /// Predicts the frame dt after the newest keyframe and updates it.
    Status update(double dt, std::span<const FeatureObservation> seen, FrameEstimate& out) {
        const Preintegration p = flight_.preintegrate(kNewest_s, kNewest_s + dt, window->newest().state.bias, noise_);
        predicted = p.predict(window->newest().state);
        predicted_covariance = propagate_covariance(window->newest().state, covariance, p, noise_);
        return update_->solve(*map, window->cameras(), kKeyframes,
                              {window->newest().state, p, predicted, covariance, noise_}, seen, out);
    }
    /// The samples of the time after the newest keyframe; each call draws their noise anew.
    Preintegration samples(double dt) {
        return flight_.preintegrate(kNewest_s, kNewest_s + dt, window->newest().state.bias, noise_);
    }
    /// The update of a keyframe whose state is displaced, which the map does not follow.
    /// @param shared  added to its covariance
    FrameEstimate updated(const Preintegration& p, std::span<const FeatureObservation> seen,
                          const StateVector& displacement, const StateMatrix& shared) {
        const NavState newest = window->newest().state.box_plus(displacement);
        const StateMatrix whole = covariance + shared;
        FrameEstimate out;
        REQUIRE(ok(update_->solve(*map, window->cameras(), kKeyframes, {newest, p, p.predict(newest), whole, noise_},
                                  seen, out)));
        return out;
    }

    NavState truth(double dt) const { return flight_.state(kNewest_s + dt); }

    const std::unique_ptr<Window> window = std::make_unique<Window>();
    const std::unique_ptr<LocalMap> map = std::make_unique<LocalMap>();
    StateMatrix covariance;
    NavState predicted;
    StateMatrix predicted_covariance;

private:
    struct Track {
        Eigen::Vector4d error = Eigen::Vector4d::Zero();
        double t = 0.0;
        bool is_known = false;
    };
    static SyntheticFlight::Options options(unsigned seed) {
        SyntheticFlight::Options o;
        o.seed = seed;
        o.gyro_noise = 1e-3;
        o.accel_noise = 3e-2;
        o.landmarks = kLandmarks;
        return o;
    }

    SyntheticFlight flight_;
    ImuNoise noise_;
    std::mt19937 generator_;
    std::normal_distribution<double> normal_;
    std::array<Track, kLandmarks> tracks_;
    const std::unique_ptr<FrameUpdate> update_ = std::make_unique<FrameUpdate>();
};

template <int kSize>
double nees(const StateMatrix& covariance, const StateVector& error, int first) {
    const Eigen::Matrix<double, kSize, 1> e = error.segment<kSize>(first);
    const Eigen::Matrix<double, kSize, kSize> c = covariance.block<kSize, kSize>(first, first);
    return e.dot(c.inverse() * e);
}

}  // namespace

TEST_CASE("a sight's Jacobians are those of its residual", "[frame_update]") {
    const Flight flight(3);
    const WindowCameras& cameras = flight.window->cameras();
    const NavState state = flight.window->newest().state.box_plus(0.01 * StateVector::Ones());
    const TrackMemory memory = TrackMemory::after(0.1);
    REQUIRE(flight.map->points().size() > 40);
    for (std::size_t i = 0; i < flight.map->points().size(); i += 7) {
        const MapPoint& point = flight.map->points()[i];
        StereoMeasurement measured;
        const auto sight_at = [&](const PoseVector& newest, const PoseVector& frame) {
            StateVector d = StateVector::Zero();
            d.head<kPoseDim>() = frame;
            const NavState moved = state.box_plus(d);
            SightResidual out;
            REQUIRE(ok(linearize_sight(point, measured, cameras.geometry(),
                                       RelativeView::of(cameras.left_of(moved), cameras.left(point.host)),
                                       moved.q_W_B.toRotationMatrix().transpose(), memory, newest, out)));
            return out;
        };
        const PoseVector zero = PoseVector::Zero();
        const SightResidual at = sight_at(zero, zero);
        test::expect_jacobian_near(
            at.d_r_d_frame, [&](const PoseVector& d) { return sight_at(zero, d).r; }, zero, 1e-5);
        test::expect_jacobian_near(
            at.d_r_d_newest, [&](const PoseVector& d) { return sight_at(d, zero).r; }, zero, 1e-5);
        CHECK(at.covariance.determinant() > 0.0);
    }
}

TEST_CASE("a point follows the newest keyframe at most as a rigid body does", "[frame_update]") {
    const Flight flight(5);
    int seen_often = 0;
    for (const MapPoint& p : flight.map->points()) {
        // A landmark seen by older keyframes too is held by them.
        const double follow = (p.covariance.inverse() * p.d_point_d_pose).norm();
        CHECK(std::isfinite(follow));
        seen_often += p.host < kKeyframes - 1 ? 1 : 0;
        CHECK(p.weight > 0.0);
        CHECK(p.weight <= 1.0);
    }
    CHECK(seen_often > 30);
    // Relative to the map the keyframe is known better than absolutely.
    const StateMatrix drift = flight.covariance - flight.map->newest_covariance();
    CHECK(drift.diagonal().segment<3>(kPos).minCoeff() > 0.0);
    CHECK(drift.diagonal().segment<3>(kTheta).minCoeff() > 0.0);
}

TEST_CASE("frames between keyframes are as certain as they report", "[frame_update]") {
    constexpr int kRuns = 40;
    const double dt = GENERATE(0.05, 0.2);
    CAPTURE(dt);
    double pose = 0.0;
    double velocity = 0.0;
    double updated_m2 = 0.0;
    double predicted_m2 = 0.0;
    for (unsigned seed = 1; seed <= kRuns; ++seed) {
        Flight flight(seed);
        const auto seen = flight.observe(kNewest_s + dt);
        FrameEstimate out;
        REQUIRE(ok(flight.update(dt, {seen.data(), seen.size()}, out)));
        const StateVector error = error_of(out.state, flight.truth(dt));
        pose += nees<6>(out.covariance, error, kTheta) / kRuns;
        velocity += nees<3>(out.covariance, error, kVel) / kRuns;
        updated_m2 += error.segment<3>(kPos).squaredNorm();
        predicted_m2 += error_of(flight.predicted, flight.truth(dt)).segment<3>(kPos).squaredNorm();
        CHECK(out.landmarks > 40);
        // Never less certain than without the image.
        CHECK(out.covariance.trace() <= flight.predicted_covariance.trace() * (1.0 + 1e-9));
    }
    // Of 40 runs: 95 % within 6 -+ 1.1 and 3 -+ 0.8 if all were normal and independent; tracks err for longer than the
    // window knows, so that it is a little too sure or too cautious.
    CHECK(pose < 9.0);
    CHECK(pose > 2.5);
    CHECK(velocity < 5.0);
    CHECK(velocity > 1.0);
    CHECK(updated_m2 < predicted_m2);
}

TEST_CASE("a frame's covariance has what it shares with the map as far as its images leave it", "[frame_update]") {
    Flight flight(11);
    const double dt = 0.2;
    const auto seen = flight.observe(kNewest_s + dt);
    const std::span<const FeatureObservation> sights{seen.data(), seen.size()};
    const Preintegration samples = flight.samples(dt);
    const StateVector zero = StateVector::Zero();
    const NavState& k = flight.window->newest().state;
    const FrameEstimate usual = flight.updated(samples, sights, zero, StateMatrix::Zero());
    const auto added_by = [&](const StateVector& d) {
        return StateMatrix(flight.updated(samples, sights, zero, d * d.transpose()).covariance - usual.covariance);
    };
    for (int i = kBiasGyro; i < kStateDim; ++i) {
        CAPTURE(i);
        const StateVector d = 1e-4 * StateVector::Unit(i);
        const StateVector answer = 0.5 * error_of(flight.updated(samples, sights, d, StateMatrix::Zero()).state,
                                                  flight.updated(samples, sights, -d, StateMatrix::Zero()).state);
        const StateMatrix expected = answer * answer.transpose();
        const StateMatrix added = added_by(d);
        // The covariance knows nothing of how the weights of the tracks follow.
        CHECK((added - expected).norm() < 0.5 * expected.norm());
        const StateVector blind = error_of(samples.predict(k.box_plus(d)), samples.predict(k));
        CHECK(added.diagonal().head<kPoseDim>().sum() < 0.9 * blind.head<kPoseDim>().squaredNorm());
    }
    // Place and yaw of all: nothing tells them.
    const Eigen::Vector3d turn_W(0.0, 0.0, 1e-3);
    StateVector d = StateVector::Zero();
    d << k.q_W_B.conjugate() * turn_W, 3e-3, -2e-3, 1e-3, turn_W.cross(k.v_W_B), Eigen::Matrix<double, 6, 1>::Zero();
    StateVector rigid = d;
    rigid.segment<3>(kTheta) = usual.state.q_W_B.conjugate() * turn_W;
    rigid.segment<3>(kPos) += turn_W.cross(usual.state.p_W_B - k.p_W_B);
    rigid.segment<3>(kVel) = turn_W.cross(usual.state.v_W_B);
    const StateMatrix expected = rigid * rigid.transpose();
    CHECK((added_by(d) - expected).norm() < 0.01 * expected.norm());
}

TEST_CASE("a third of the tracks on something that moves does not carry the vehicle away", "[frame_update]") {
    Flight flight(7);
    const double dt = 0.1;
    auto seen = flight.observe(kNewest_s + dt);
    FrameEstimate clean;
    REQUIRE(ok(flight.update(dt, {seen.data(), seen.size()}, clean)));
    for (std::size_t i = 0; i < seen.size(); i += 3) {
        seen[i].left_xy.x() += 15.0 / 458.0;
    }
    FrameEstimate disturbed;
    REQUIRE(ok(flight.update(dt, {seen.data(), seen.size()}, disturbed)));
    CHECK((disturbed.state.p_W_B - flight.truth(dt).p_W_B).norm() <
          (clean.state.p_W_B - flight.truth(dt).p_W_B).norm() + 0.005);
}

TEST_CASE("images worse than the window's are seen in the residuals and believed less", "[frame_update]") {
    Flight flight(9);
    const double dt = 0.1;
    auto seen = flight.observe(kNewest_s + dt);
    FrameEstimate clean;
    REQUIRE(ok(flight.update(dt, {seen.data(), seen.size()}, clean)));
    CHECK(clean.chi2 < 2.0);
    std::mt19937 generator(1);
    std::normal_distribution<double> normal;
    for (FeatureObservation& o : seen) {
        o.left_xy.x() += 4.0 * kPixelSigma / 458.0 * normal(generator);
        o.left_xy.y() += 4.0 * kPixelSigma / 458.0 * normal(generator);
    }
    FrameEstimate blurred;
    REQUIRE(ok(flight.update(dt, {seen.data(), seen.size()}, blurred)));
    CHECK(blurred.chi2 > 4.0 * clean.chi2);
    CHECK(blurred.covariance(kVel, kVel) > clean.covariance(kVel, kVel));
}

TEST_CASE("with too few landmarks of the map in the image there is no update", "[frame_update]") {
    Flight flight(2);
    auto seen = flight.observe(kNewest_s + 0.1);
    seen.resize(FrameUpdate::kMinLandmarks - 1);
    FrameEstimate out;
    out.landmarks = 77;
    CHECK(flight.update(0.1, {seen.data(), seen.size()}, out) == Status::kNotFound);
    for (FeatureObservation& o : seen) {
        o.landmark.value += kLandmarks;  // unknown ones
    }
    CHECK(flight.update(0.1, {seen.data(), seen.size()}, out) == Status::kNotFound);
    CHECK(out.landmarks == 77);
}

TEST_CASE("an update uses no heap and depends on its input alone", "[frame_update]") {
    Flight flight(4);
    const auto seen = flight.observe(kNewest_s + 0.1);
    FrameEstimate first;
    FrameEstimate second;
    const Preintegration p = SyntheticFlight({}).preintegrate(0.0, 0.1, {}, test::euroc_like_noise());
    const NavState state = p.predict(flight.window->newest().state);
    const FramePrediction prediction{flight.window->newest().state, p, state, flight.covariance,
                                     test::euroc_like_noise()};
    const auto update = std::make_unique<FrameUpdate>();
    const test::AllocationGuard guard;
    (void)flight.window->fill_map(*flight.map);
    (void)update->solve(*flight.map, flight.window->cameras(), kKeyframes, prediction, {seen.data(), seen.size()},
                        first);
    const auto allocations = guard.allocations();
    (void)update->solve(*flight.map, flight.window->cameras(), kKeyframes, prediction, {seen.data(), seen.size()},
                        second);
    CHECK(allocations == 0);
    CHECK(first.state.p_W_B == second.state.p_W_B);
    CHECK(first.covariance == second.covariance);
}

TEST_CASE("the newest keyframe given the others' poses is what the whole system says", "[frame_update]") {
    constexpr int kCount = 5;
    constexpr int kGlobals = 2;
    std::mt19937 generator(1);
    std::normal_distribution<double> normal;
    const auto system = std::make_unique<ReducedSystem>();
    system->reset(kCount, kGlobals);
    auto h = system->h();
    const int n = system->dim();
    // Links between neighbours as inertial factors make them; images tie poses and globals, all to all.
    for (int k = 0; k < kCount; ++k) {
        const int first = system->offset(std::max(0, k - 1));
        const int size = system->offset(k) + kStateDim - first;
        const Eigen::MatrixXd j = Eigen::MatrixXd::NullaryExpr(size, size, [&] { return normal(generator); });
        h.block(first, first, size, size) += j.transpose() * j;
    }
    for (int i = 0; i < n; ++i) {
        Eigen::VectorXd j = Eigen::VectorXd::NullaryExpr(n, [&] { return normal(generator); });
        for (int k = 0; k < kCount; ++k) {
            j.segment(system->offset(k) + kVel, kStateDim - kVel).setZero();
        }
        h += j * j.transpose();
    }
    StateCovariance information;
    REQUIRE(ok(newest_information(*system, information)));
    std::vector<int> rows;  // velocities and biases, and the newest pose
    for (int k = 0; k < kCount; ++k) {
        for (int i = k + 1 < kCount ? kVel : 0; i < kStateDim; ++i) {
            rows.push_back(system->offset(k) + i);
        }
    }
    const Eigen::MatrixXd inverse = Eigen::MatrixXd(h)(rows, rows).inverse();
    const StateCovariance expected = inverse.bottomRightCorner<kStateDim, kStateDim>().inverse();
    CHECK((information - expected).norm() < 1e-8 * expected.norm());
}

}  // namespace facet::frame_update_test
