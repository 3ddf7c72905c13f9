// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/calibrate/flight_motion.h"

#include <catch2/catch.hpp>

#include "app/lab/calibrate/calibrate.h"
#include "tests/support/asl_folder.h"
#include "tests/support/synthetic_flight.h"
#include "tests/support/temp_dir.h"

namespace facet::flight_motion_test {
namespace {

/// Keyframes of states that a function of time gives.
template <class StateAt>
FlightMotion motion_of(StateAt state_at, double seconds = 15.0) {
    RecordedFlight flight;
    for (double t = 0.0; t < seconds; t += 0.25) {
        flight.keyframes.push_back({test::at(t), test::at(t), state_at(t), {}});
    }
    return measure_motion(flight);
}

TEST_CASE("a lively flight is accepted, a short one is not") {
    const test::SyntheticFlight flight{test::SyntheticFlight::Options{}};
    const auto state_at = [&](double t) { return flight.state(t); };
    CHECK(motion_complaint(motion_of(state_at)).empty());
    CHECK(motion_complaint(motion_of(state_at, 3.0)).find("too short") != std::string::npos);
}

TEST_CASE("standing, flying straight and turning about one axis are refused") {
    const auto standing = [](double) { return NavState{}; };
    CHECK(motion_complaint(motion_of(standing)).find("stands") != std::string::npos);
    const auto straight = [](double t) {
        NavState state;
        state.p_W_B.x() = t;
        state.v_W_B.x() = 1.0;
        return state;
    };
    CHECK(motion_complaint(motion_of(straight)).find("too straight") != std::string::npos);
    const auto yawing = [&](double t) {
        NavState state = straight(t);
        state.q_W_B = so3_exp({0.0, 0.0, t});
        return state;
    };
    CHECK(motion_complaint(motion_of(yawing)).find("pitch and roll") != std::string::npos);
    CHECK_FALSE(motion_complaint(measure_motion({})).empty());
}

TEST_CASE("the attitude's spread is that about the mean attitude") {
    const auto nodding = [](double t) {
        NavState state;
        state.q_W_B = so3_exp({0.0, 0.0, 2.0}) * so3_exp({0.0, 0.1 * std::sin(t), 0.0});
        return state;
    };
    const FlightMotion motion = motion_of(nodding, 25.132);
    CHECK(motion.turned_rad.x() == Approx(0.1 / std::sqrt(2.0)).epsilon(0.02));
    CHECK(motion.turned_rad.y() < 1e-6);
}

TEST_CASE("a log of a vehicle at rest is refused, and nothing is written") {
    const test::TempDir dir;
    test::write_asl_folder(dir, 20);
    CalibrateOptions options;
    options.recording.dataset = dir.path();
    options.recording.calibration = load_euroc_calibration(dir.file("mav0"));
    options.recording.show_progress = false;
    options.out = dir.file("out");
    const std::atomic<bool> stop{false};
    CHECK_FALSE(calibrate(options, stop).refusal.empty());
    CHECK_FALSE(std::filesystem::exists(options.out));
}

TEST_CASE("a principal point or a rotation that stays unseen is named") {
    std::vector<RigParameter> parameters(2);
    parameters[0].name = "cam0.place_x";
    parameters[1].name = "cam1.cy";
    parameters[1].advice = "fly more yaw";
    CHECK(unseen_complaint(parameters).find("cam1.cy: fly more yaw") != std::string::npos);
    parameters[1].verdict = ParameterVerdict::kWeak;
    CHECK(unseen_complaint(parameters).empty());
}

}  // namespace
}  // namespace facet::flight_motion_test
