// SPDX-License-Identifier: BSD-2-Clause
// The window's linearization against numeric differentiation of its cost, landmarks triangulated anew each time.
#include "estimator/window/window_problem.h"

#include <catch2/catch.hpp>
#include <memory>
#include <vector>

#include "estimator/window/outlier_removal.h"
#include "tests/support/synthetic_flight.h"

namespace facet::window_problem_test {

using facet::test::SyntheticFlight;

namespace {

constexpr int kKeyframes = 3;
constexpr double kStep_s = 0.3;

struct Fixture {
    WindowConfig config;
    CalibrationConfig calibration;
    RegularityConfig regularity;
    RangeConfig range;
    std::unique_ptr<WindowState> state = std::make_unique<WindowState>();
    std::unique_ptr<ReducedSystem> system = std::make_unique<ReducedSystem>();
    std::unique_ptr<WindowCameras> cameras = std::make_unique<WindowCameras>();
    std::unique_ptr<WindowProblem> problem = std::make_unique<WindowProblem>();

    explicit Fixture(double pixel_sigma, bool calibrate = false, bool with_planes = false) {
        calibration.estimate_time_offset = calibrate;
        calibration.estimate_extrinsics = calibrate;
        calibration.estimate_cameras = calibrate;
        SyntheticFlight::Options options;
        options.pixel_sigma = pixel_sigma;
        options.landmarks = 120;
        options.in_room = with_planes;
        SyntheticFlight flight(options);
        config.loss_threshold = 10.0;
        cameras->bind(*state, config, calibration, flight.rig());
        problem->bind(*state, *cameras, calibration, regularity, range);
        for (int k = 0; k < kKeyframes; ++k) {
            Keyframe keyframe;
            keyframe.stamp = test::at(kStep_s * k);
            keyframe.state = flight.state(kStep_s * k);
            keyframe.w_B = flight.rate(kStep_s * k);
            if (k > 0) {
                const Preintegration p = flight.preintegrate(kStep_s * (k - 1), kStep_s * k, {}, {});
                REQUIRE(ok(keyframe.imu_from_previous.set(p, {})));
            }
            keyframe.state_lin = keyframe.state;
            state->keyframes.push_back(keyframe);
            for (const FeatureObservation& o : flight.observe(kStep_s * k, 60)) {
                state->landmarks.find_or_insert(o.landmark)->observations.push_back(cameras->observe(k, o));
            }
        }
        if (calibrate) {
            state->calibration.T_B_Bc = {so3_exp({0.01, -0.02, 0.015}), {0.02, 0.01, -0.03}};
            state->calibration.right = {so3_exp({-0.001, 0.002, 0.001}), {0.001, -0.002, 0.001}};
            state->calibration.lens[0] << 1e-3, -2e-3, 0.5, -0.3, 1e-3, -1e-3, 2e-4, -3e-4;
            state->calibration.lens[1] << -1e-3, 1e-3, -0.4, 0.2, -1e-3, 5e-4, -1e-4, 2e-4;
        }
        if (with_planes) {
            add_planes(flight.planes());
        }
        state->prior.reset(1, problem->globals());
        state->prior.h().diagonal().setConstant(100.0);
        state->prior.g().setConstant(0.3);
    }

    /// The room's planes, a little off, with their landmarks; one wall is held upright, the floor level.
    void add_planes(const PlaneProposals& planes) {
        regularity.mode = RegularityMode::kSpr;
        regularity.huber_threshold = 1000.0;
        for (const PlaneProposal& proposal : planes) {
            WindowPlane plane;
            plane.kind = proposal.kind;
            plane.plane = Plane::from(proposal.normal_W, proposal.distance_m, 4.5 * -proposal.normal_W)
                              .box_plus({0.004, -0.003, 0.005});
            plane.plane_lin = plane.plane;
            for (const LandmarkId id : proposal.landmarks) {
                if (Landmark* landmark = state->landmarks.find(id)) {
                    landmark->plane = static_cast<int>(state->planes.size());
                }
            }
            state->planes.push_back(plane);
        }
        for (const PlaneKind kind : {PlaneKind::kHorizontal, PlaneKind::kVertical}) {
            const auto plane = std::find_if(state->planes.begin(), state->planes.end(),
                                            [=](const WindowPlane& p) { return p.kind == kind; });
            REQUIRE(plane != state->planes.end());
            plane->is_aligned = true;
        }
    }

    /// Cost with the states moved by `d`; the states are put back.
    double cost_at(const Eigen::VectorXd& d) {
        problem->save();
        const int globals = problem->globals();
        RigCalibration::Tangent correction = RigCalibration::Tangent::Zero();
        correction.head(calibration.dim()) = d.head(calibration.dim());
        state->calibration = state->calibration.box_plus(correction);
        for (int p = 0; p < static_cast<int>(state->planes.size()); ++p) {
            WindowPlane& plane = state->planes[static_cast<std::size_t>(p)];
            plane.plane = plane.plane.box_plus(d.segment<kPlaneDim>(problem->plane_row(p)));
        }
        for (int k = 0; k < kKeyframes; ++k) {
            Keyframe& keyframe = state->keyframes[static_cast<std::size_t>(k)];
            keyframe.state = keyframe.state.box_plus(d.segment<kStateDim>(globals + kStateDim * k));
        }
        for (int pass = 0; pass < 3; ++pass) {  // let the landmarks settle
            problem->linearize(*system);
        }
        const double cost = problem->linearize(*system);
        problem->restore();
        return cost;
    }

    /// Of numeric differentiation. Lenses must move by more than observations may lag behind them.
    double step_of(int parameter) const {
        for (const int lens : {kLeftLens, kRightLens}) {
            const int i = parameter - lens;
            if (parameter < calibration.dim() && i >= 0 && i < kLensDim) {
                return i >= kLensPrincipal && i < kLensDistortion ? 5e-3 : 1e-5;
            }
        }
        return 1e-6;
    }
};

}  // namespace

TEST_CASE("the window's gradient is the derivative of its cost", "[window_problem]") {
    const bool calibrate = GENERATE(false, true);
    const bool with_planes = GENERATE(false, true);
    Fixture f(0.5, calibrate, with_planes);
    f.problem->select_landmarks();
    for (int pass = 0; pass < 20; ++pass) {  // until the landmarks have settled: the calibration is far off
        f.problem->linearize(*f.system);
    }
    f.problem->linearize(*f.system);
    CHECK(f.problem->fit().active_landmarks > 15);
    const Eigen::VectorXd gradient = f.system->g();
    for (int i = 0; i < f.system->dim(); ++i) {
        Eigen::VectorXd d = Eigen::VectorXd::Zero(f.system->dim());
        const double step = f.step_of(i);
        d(i) = step;
        const double plus = f.cost_at(d);
        const double minus = f.cost_at(-d);
        INFO("parameter " << i);
        CHECK((plus - minus) / (2.0 * step) ==
              Approx(gradient(i)).epsilon(0.01).margin(2e-3 * gradient.cwiseAbs().maxCoeff()));
    }
}

TEST_CASE("a landmark that leaves the optimization does not look like a gain", "[window_problem]") {
    Fixture f(0.0);
    f.problem->select_landmarks();
    const double cost = f.problem->linearize(*f.system);
    // All keyframes turned round: every landmark is behind its camera and keeps the cost it had.
    for (Keyframe& keyframe : f.state->keyframes) {
        keyframe.state.q_W_B = keyframe.state.q_W_B * so3_exp({0.0, 0.0, 3.0});
    }
    CHECK(f.problem->linearize(*f.system) >= cost);
}

TEST_CASE("outliers are taken out, the rest stays", "[outlier_removal]") {
    Fixture f(0.3);
    const int before = f.state->landmarks.size();
    // One newest left measurement 8 px off, one older right measurement 8 px off.
    const double off = 8.0 / 458.0;
    Landmark* left_wrong = nullptr;
    Landmark* right_wrong = nullptr;
    for (int i = 0; i < before; ++i) {
        Landmark& l = f.state->landmarks[i];
        if (l.observations.size() == kKeyframes && l.observations[1].measurement.has_right) {
            if (left_wrong == nullptr) {
                left_wrong = &l;
            } else if (right_wrong == nullptr) {
                right_wrong = &l;
            }
        }
    }
    REQUIRE(right_wrong != nullptr);
    left_wrong->observations.back().measurement.left_xy.x() += off;
    right_wrong->observations[1].measurement.right_xy.y() += off;
    const LandmarkId left_id = left_wrong->id;
    const LandmarkId right_id = right_wrong->id;
    f.problem->select_landmarks();
    boost::container::static_vector<LandmarkId, kMaxFeatures> rejected;
    const OutlierCount count = remove_outliers(4.0, *f.state, *f.cameras, rejected);
    CHECK(count.observations == 2);
    CHECK(count.landmarks == 0);
    CHECK(f.state->landmarks.size() == before);
    REQUIRE(rejected.size() == 1);
    CHECK(rejected[0] == left_id);
    CHECK(f.state->landmarks.find(left_id)->observations.size() == kKeyframes - 1);
    CHECK_FALSE(f.state->landmarks.find(right_id)->observations[1].measurement.has_right);
    CHECK(f.state->landmarks.find(right_id)->observations.size() == kKeyframes);
}

TEST_CASE("a step that is taken back leaves the landmarks as they were", "[window_problem]") {
    Fixture f(0.5, false, true);
    f.problem->select_landmarks();
    const double cost = f.problem->linearize(*f.system);
    const auto fits = [&] {
        std::vector<LandmarkFit> all;
        for (int i = 0; i < f.state->landmarks.size(); ++i) {
            all.push_back(f.state->landmarks[i]);
        }
        return all;
    };
    const std::vector<LandmarkFit> before = fits();
    f.problem->save();
    f.state->keyframes.back().state.p_W_B.x() += 0.3;
    CHECK(f.problem->linearize(*f.system) > cost);
    f.problem->restore();
    const std::vector<LandmarkFit> after = fits();
    for (std::size_t i = 0; i < before.size(); ++i) {
        REQUIRE(after[i].point.xy == before[i].point.xy);
        REQUIRE(after[i].point.rho == before[i].point.rho);
        REQUIRE(after[i].cost == before[i].cost);
        REQUIRE(after[i].squared_error == before[i].squared_error);
        REQUIRE(after[i].plane_chi2 == before[i].plane_chi2);
    }
    CHECK(f.problem->linearize(*f.system) <= cost * (1.0 + 1e-9));
}

TEST_CASE("a change of scale costs nothing that images tell, however far it moves points in them", "[window_problem]") {
    // GIVEN one camera, a robust loss that takes what is far off for an outlier, and some outliers
    Fixture f(0.15);
    f.config.loss_threshold = 1.2;
    f.config.pixel_sigma_px = 0.15;
    f.cameras->bind(*f.state, f.config, f.calibration, SyntheticFlight(SyntheticFlight::Options{}).rig());
    f.cameras->set_settled(true);
    for (int i = 0; i < f.state->landmarks.size(); ++i) {
        for (LandmarkObservation& o : f.state->landmarks[i].observations) {
            o.measurement.has_right = false;
            if (i % 5 == 0 && o.keyframe == 1) {
                o.measurement.left_xy.x() += 1.0 / 458.0;
            }
        }
    }
    const auto image_cost = [&] {
        double sum = 0.0;
        for (int i = 0; i < f.state->landmarks.size(); ++i) {
            sum += f.state->landmarks[i].is_active ? f.state->landmarks[i].cost : 0.0;
        }
        return sum;
    };
    f.problem->select_landmarks();
    for (int pass = 0; pass < 20; ++pass) {
        f.problem->linearize(*f.system);
    }
    const double cost = image_cost();
    REQUIRE(f.problem->fit().active_landmarks > 15);
    // WHEN all keyframes draw near to the first one by a twentieth
    f.problem->save();
    for (Keyframe& keyframe : f.state->keyframes) {
        const Eigen::Vector3d& origin = f.state->keyframes.front().state.p_W_B;
        keyframe.state.p_W_B = origin + 0.95 * (keyframe.state.p_W_B - origin);
    }
    f.problem->linearize(*f.system);
    // THEN the points follow at once
    CHECK(image_cost() < 1.1 * cost);
}

}  // namespace facet::window_problem_test
