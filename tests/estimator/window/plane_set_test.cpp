// SPDX-License-Identifier: BSD-2-Clause
// Planes in the window, on synthetic flights in a room: what they gain, and that they come and go cleanly.
#include "estimator/window/plane_set.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "estimator/window/window.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/synthetic_flight.h"

namespace facet::plane_set_test {

using facet::test::SyntheticFlight;

namespace {

using StateMatrix = Eigen::Matrix<double, kStateDim, kStateDim>;
using StateVector = Eigen::Matrix<double, kStateDim, 1>;

constexpr double kStep = 0.2;

/// The flight's cameras are as given: what planes do is not mixed up with what is learned of cameras.
CalibrationConfig exact_cameras() {
    CalibrationConfig calibration;
    calibration.estimate_cameras = false;
    return calibration;
}

/// A window that follows a noisy flight.
class Flight {
public:
    explicit Flight(RegularityMode mode, unsigned seed = 1, bool in_room = true, double max_plane_chi2 = 1.0)
        : flight_(make_options(seed, in_room)) {
        WindowConfig config;
        config.pixel_sigma_px = 0.5;
        config.learn_pixel_sigma = false;
        config.keyframes = 10;
        RegularityConfig regularity;
        regularity.mode = mode;
        regularity.max_plane_chi2 = max_plane_chi2;
        window_->configure(config, exact_cameras(), flight_.rig(), noise_, regularity);
        NavState start = flight_.state(0.0);
        std::mt19937 generator(seed + 100);
        std::normal_distribution<double> normal;
        StateVector d = StateVector::Zero();
        for (int i = 0; i < 9; ++i) {
            d(i) = test::start_sigmas()(i) * normal(generator);
        }
        const StateMatrix information = test::start_sigmas().cwiseAbs2().cwiseInverse().asDiagonal();
        const auto first = flight_.observe(0.0);
        window_->start({test::at(0.0), Eigen::Vector3d::Zero(), false, {first.data(), first.size()}}, start.box_plus(d),
                       information);
    }

    /// One keyframe on, with these planes proposed.
    void step(const PlaneProposals& proposals) {
        const double before = t_;
        t_ += kStep;
        const Preintegration p = flight_.preintegrate(before, t_, window_->newest().state.bias, noise_);
        const auto observations = flight_.observe(t_);
        window_->set_planes(proposals);
        REQUIRE(ok(window_->add_keyframe(
            {test::at(t_), flight_.rate(t_), false, {observations.data(), observations.size()}}, p)));
        const WindowSummary summary = window_->optimize();
        REQUIRE_FALSE(summary.solver.solver_failed);
        REQUIRE_FALSE(summary.marginalization_failed);
    }
    void fly(double seconds, const PlaneProposals& proposals) {
        for (int k = 0; k < std::lround(seconds / kStep); ++k) {
            step(proposals);
        }
    }

    StateVector error() const { return window_->newest().state.box_minus_to(flight_.state(t_)); }
    double pose_nees() {
        StateMatrix covariance;
        REQUIRE(ok(window_->newest_covariance(covariance)));
        const Eigen::Matrix<double, 6, 1> d = error().head<6>();
        return d.dot(covariance.topLeftCorner<6, 6>().inverse() * d);
    }
    Window& window() { return *window_; }
    const WindowPlanes& planes() const { return window_->state().planes; }
    SyntheticFlight& truth() { return flight_; }

private:
    static SyntheticFlight::Options make_options(unsigned seed, bool in_room) {
        SyntheticFlight::Options options;
        options.gyro_noise = 1.7e-4;
        options.accel_noise = 2e-3;
        options.pixel_sigma = 0.5;
        options.bias.gyro = {0.005, -0.008, 0.006};
        options.bias.accel = {0.03, -0.04, 0.02};
        options.landmarks = 600;
        options.in_room = in_room;
        options.seed = seed;
        return options;
    }

    SyntheticFlight flight_;
    ImuNoise noise_ = test::euroc_like_noise();
    std::unique_ptr<Window> window_ = std::make_unique<Window>();
    double t_ = 0.0;
};

int held(const Window& window) {
    int count = 0;
    for (int i = 0; i < window.state().landmarks.size(); ++i) {
        count += window.state().landmarks[i].plane != Landmark::kNoPlane ? 1 : 0;
    }
    return count;
}

}  // namespace

TEST_CASE("planes: a room's sides come in, and are found where they are", "[plane_set]") {
    Flight flight(RegularityMode::kSpr);
    const PlaneProposals room = flight.truth().planes();
    flight.fly(6.0, room);
    REQUIRE(flight.planes().size() >= 2);  // what the camera has seen
    for (const WindowPlane& plane : flight.planes()) {
        const PlaneProposal& truth = room[plane.id.value];
        INFO("plane " << plane.id.value << " constraints " << plane.constraints << " chi2 " << plane.mean_chi2);
        CHECK(plane.plane.normal_W().cross(truth.normal_W).norm() < 0.005);
        CHECK(plane.plane.distance_m() == Approx(truth.distance_m).margin(0.05));
        CHECK(plane.mean_chi2 < 2.0);
        CHECK(plane.constraints >= 20);
    }
}

TEST_CASE("planes: the estimate gains by them and stays consistent", "[plane_set]") {
    constexpr int kRuns = 6;
    constexpr double kSeconds = 16.0;
    double squared[2] = {0.0, 0.0};
    double nees = 0.0;
    int count = 0;
    for (unsigned seed = 1; seed <= kRuns; ++seed) {
        for (const int mode : {0, 1}) {
            Flight flight(mode == 0 ? RegularityMode::kS : RegularityMode::kSpr, seed);
            const PlaneProposals room = flight.truth().planes();
            for (double t = 0.0; t < kSeconds; t += kStep) {
                flight.step(room);
                squared[mode] += flight.error().segment<3>(kPos).squaredNorm();
            }
            if (mode == 1) {
                nees += flight.pose_nees();
                ++count;
            }
        }
    }
    INFO("RMSE of SPR over S " << std::sqrt(squared[1] / squared[0]) << ", pose NEES " << nees / count);
    CHECK(squared[1] < 0.8 * squared[0]);
    CHECK(nees / count < 10.5);  // 99.9 % of the mean of 6 chi-squares of 6 degrees of freedom
}

TEST_CASE("planes: heights above one plane share errors, which more landmarks do not average out", "[plane_set]") {
    const RegularityConfig config;
    CHECK(config.weigh_m(0) == config.sigma_m);
    CHECK(config.weigh_m(1) == config.sigma_m);
    double mean_variance_m2 = std::pow(config.sigma_m, 2);
    for (int count = 2; count <= kMaxPlaneLandmarks; ++count) {
        const double less = std::pow(config.weigh_m(count), 2) / count;
        CHECK(less < mean_variance_m2);  // one more landmark always tells something
        mean_variance_m2 = less;
    }
    CHECK(mean_variance_m2 > config.height_correlation * std::pow(config.sigma_m, 2));

    Flight flight(RegularityMode::kSpr);
    flight.fly(2.0, flight.truth().planes());
    REQUIRE_FALSE(flight.planes().empty());
    for (const WindowPlane& plane : flight.planes()) {
        CHECK(plane.constraints > 1);
        CHECK(plane.sigma_m >= config.weigh_m(plane.constraints));  // those that have left since counted then
    }
}

TEST_CASE("planes: without any, SPR is S to the bit", "[plane_set]") {
    Flight s(RegularityMode::kS);
    Flight spr(RegularityMode::kSpr);
    s.fly(4.0, s.truth().planes());
    spr.fly(4.0, {});
    CHECK(s.window().newest().state.p_W_B == spr.window().newest().state.p_W_B);
    CHECK(s.window().newest().state.q_W_B.coeffs() == spr.window().newest().state.q_W_B.coeffs());
    CHECK(s.window().newest().state.bias.accel == spr.window().newest().state.bias.accel);
    CHECK(s.planes().empty());
}

TEST_CASE("planes: out of sight a plane lets its landmarks go, and stays if the prior knows it", "[plane_set]") {
    Flight flight(RegularityMode::kSpr);
    const PlaneProposals room = flight.truth().planes();
    flight.fly(6.0, room);
    const auto known =
        std::count_if(flight.planes().begin(), flight.planes().end(), [](const WindowPlane& p) { return p.is_bound; });
    REQUIRE(known >= 2);
    flight.step({});
    CHECK(static_cast<std::ptrdiff_t>(flight.planes().size()) == known);
    CHECK(held(flight.window()) == 0);
    CHECK(flight.window().state().prior.globals() == exact_cameras().dim() + kPlaneDim * known);
    flight.fly(2.0, {});
    CHECK(flight.error().segment<3>(kPos).norm() < 0.05);
    flight.step(room);
    CHECK(held(flight.window()) > 20);
}

TEST_CASE("planes: one that comes back where it was not restarts, and says nothing of the drift", "[plane_set]") {
    Flight flight(RegularityMode::kSpr);
    PlaneProposals room = flight.truth().planes();
    flight.fly(6.0, room);
    REQUIRE(flight.planes().size() >= 2);
    const std::uint32_t a = flight.planes()[0].id.value;
    const std::uint32_t b = flight.planes()[1].id.value;
    REQUIRE(flight.planes()[0].is_bound);
    flight.fly(1.0, {});
    std::swap(room[a], room[b]);  // each is taken for the other
    std::swap(room[a].id, room[b].id);
    flight.step(room);
    CHECK(held(flight.window()) > 20);
    for (const WindowPlane& plane : flight.planes()) {
        const PlaneProposal& now = room[plane.id.value];
        CHECK((plane.plane.normal_W() - now.normal_W).norm() < 0.01);
        CHECK(plane.plane.distance_m() == Approx(now.distance_m).margin(0.05));
    }
    flight.fly(2.0, room);
    CHECK(flight.error().segment<3>(kPos).norm() < 0.05);
}

TEST_CASE("planes: when all places are taken, the one unseen for longest leaves, also out of the prior",
          "[plane_set]") {
    Flight flight(RegularityMode::kSpr);
    PlaneProposals room = flight.truth().planes();
    int rounds_with_new = 0;
    for (std::uint32_t round = 0; round < 20; ++round) {  // ever new names for the same sides
        for (PlaneProposal& plane : room) {
            plane.id = {plane.id.value % 10 + 10 * round};
        }
        flight.fly(1.0, room);
        const WindowPlanes& planes = flight.planes();
        REQUIRE(planes.size() <= kMaxPlanes);
        CHECK(flight.window().state().prior.globals() ==
              exact_cameras().dim() + kPlaneDim * static_cast<int>(planes.size()));
        const bool has_new =
            std::any_of(planes.begin(), planes.end(), [&](const WindowPlane& p) { return p.id.value >= 10 * round; });
        rounds_with_new += has_new ? 1 : 0;
    }
    CHECK(rounds_with_new >= 18);  // in one or two no side has as many landmarks as a plane begins with
    CHECK(flight.planes().size() == kMaxPlanes);
    CHECK(flight.error().segment<3>(kPos).norm() < 0.1);
}

TEST_CASE("planes: clutter named a plane is not taken", "[plane_set]") {
    Flight flight(RegularityMode::kSpr, 3, false);
    PlaneProposals clutter;
    PlaneProposal plane;
    plane.id = {7};
    plane.kind = PlaneKind::kVertical;
    plane.normal_W = -Eigen::Vector3d::UnitX();
    plane.distance_m = -5.0;
    for (std::uint32_t i = 0; i < 250; ++i) {
        plane.landmarks.push_back({i});
    }
    clutter.push_back(plane);
    flight.fly(4.0, clutter);
    CHECK(flight.planes().empty());
}

TEST_CASE("planes: one that was given up may return, after waits that double", "[plane_set]") {
    Flight flight(RegularityMode::kSpr, 1, true, 1e-6);  // no plane is right enough
    const PlaneProposals room = flight.truth().planes();
    std::map<std::uint32_t, std::vector<int>> present;  // keyframes by plane
    for (int k = 0; k < 75; ++k) {
        flight.step(room);
        for (const WindowPlane& plane : flight.planes()) {
            present[plane.id.value].push_back(k);
        }
    }
    int returns = 0;
    for (const auto& [id, keyframes] : present) {
        int least = 8;
        for (std::size_t i = 1; i < keyframes.size(); ++i) {
            const int away = keyframes[i] - keyframes[i - 1];
            if (away > 1) {
                INFO("plane " << id << " returns at keyframe " << keyframes[i] << " after " << away);
                CHECK(away >= least);
                least *= 2;
                ++returns;
            }
        }
        CHECK(keyframes.size() <= 2 * 4);  // two keyframes each time: 8 + 16 + 32 lie between
    }
    CHECK(returns >= 2);
}

TEST_CASE("planes: a plane that turns out false is given up within a second and gains nothing by returning",
          "[plane_set]") {
    // The landmarks of one wall are said to lie on a wall 6 cm nearer: near enough to be taken for it at first.
    Flight flight(RegularityMode::kSpr);
    Flight reference(RegularityMode::kS);
    PlaneProposals room = flight.truth().planes();
    PlaneProposals false_wall;
    PlaneProposal curved = room[2];
    curved.landmarks.clear();
    for (const LandmarkId id : room[2].landmarks) {
        curved.landmarks.push_back(id);
    }
    for (const LandmarkId id : room[4].landmarks) {  // and those of the wall beside it
        static_cast<void>(curved.landmarks.try_push_back(id));
    }
    std::sort(curved.landmarks.begin(), curved.landmarks.end());
    curved.normal_W = Eigen::Vector3d(-1.0, -1.0, 0.0).normalized();
    curved.distance_m = -6.0;
    false_wall.push_back(curved);
    flight.fly(5.0, false_wall);
    reference.fly(5.0, {});
    CHECK(flight.error().segment<3>(kPos).norm() < reference.error().segment<3>(kPos).norm() + 0.02);
}

TEST_CASE("planes: proposals that are none do no harm", "[plane_set]") {
    Flight flight(RegularityMode::kSpr);
    PlaneProposals bad = flight.truth().planes();
    bad[0].normal_W = {std::nan(""), 0.0, 1.0};
    bad[1].normal_W.setZero();
    bad[2].landmarks.clear();
    for (LandmarkId& id : bad[3].landmarks) {
        id = {1000000 + id.value};  // unknown
    }
    flight.fly(3.0, bad);
    for (const WindowPlane& plane : flight.planes()) {
        CHECK(plane.id.value >= 4);
    }
    CHECK(flight.error().segment<3>(kPos).norm() < 0.1);
}

TEST_CASE("planes: no heap", "[plane_set]") {
    Flight flight(RegularityMode::kSpr);
    const PlaneProposals room = flight.truth().planes();
    flight.fly(4.0, room);
    const Preintegration p = flight.truth().preintegrate(4.0, 4.2, flight.window().newest().state.bias, ImuNoise{});
    const auto observations = flight.truth().observe(4.2);
    const test::AllocationGuard guard;
    flight.window().set_planes(room);
    REQUIRE(ok(flight.window().add_keyframe(
        {test::at(4.2), Eigen::Vector3d::Zero(), false, {observations.data(), observations.size()}}, p)));
    flight.window().optimize();
    flight.window().set_planes({});
    flight.window().optimize();
    if (test::AllocationGuard::active()) {
        CHECK(guard.allocations() == 0);
    }
}

}  // namespace facet::plane_set_test
