// SPDX-License-Identifier: BSD-2-Clause
// Flights: exact derivatives, standing start, limits and clearance, dependence on the seed.
#include "app/lab/sim/flight.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "estimator/geometry/so3.h"
#include "tests/app/lab/sim/draft_scene.h"

namespace facet::sim::flight_test {
namespace {

Flight planned(std::string_view scene, std::uint64_t seed, double duration_s) {
    FlightPlan plan;
    plan.duration_s = duration_s;
    plan.seed = seed;
    Flight flight;
    REQUIRE(ok(plan_flight(draft_scene(scene), plan, flight)));
    return flight;
}

TEST_CASE("Velocity, acceleration and body rate agree with numeric differentiation") {
    const Flight flight = planned("room", 5, 12.0);
    const double h = 1e-5;
    for (double t = 2.0; t < 11.5; t += 0.11) {
        const FlightState before = flight.evaluate(t - h);
        const FlightState at = flight.evaluate(t);
        const FlightState after = flight.evaluate(t + h);
        CHECK((at.v_W - (after.T_W_B.p - before.T_W_B.p) / (2.0 * h)).norm() < 1e-7);
        CHECK((at.a_W - (after.v_W - before.v_W) / (2.0 * h)).norm() < 1e-6);
        CHECK((at.w_B - so3_log(before.T_W_B.q.conjugate() * after.T_W_B.q) / (2.0 * h)).norm() < 1e-7);
    }
}

TEST_CASE("Flights start standing, level within the mount, camera forward") {
    const Flight flight = planned("hall", 1, 8.0);
    const FlightState start = flight.evaluate(0.0);
    for (double t = 0.0; t < 2.5; t += 0.1) {
        const FlightState s = flight.evaluate(t);
        CHECK(s.v_W.norm() < 1e-12);
        CHECK(s.a_W.norm() < 1e-12);
        CHECK(s.w_B.norm() < 1e-12);
        CHECK((s.T_W_B.p - start.T_W_B.p).norm() < 1e-12);
    }
    CHECK((start.T_W_B.q * Eigen::Vector3d::UnitX()).z() > 0.98);           // the sensor's x points up
    CHECK(std::abs((start.T_W_B.q * Eigen::Vector3d::UnitZ()).z()) < 0.2);  // its z, the view, nearly level
}

TEST_CASE("Planned flights keep clearance and limits in all scenes") {
    for (const std::string_view name : scene_names()) {
        for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
            const Scene& scene = draft_scene(name);
            const FlightReport report = inspect_flight(planned(name, seed, 31.0), scene);
            CHECK(report.min_clearance_m >= scene.flight_volume().clearance_m);
            CHECK(report.max_speed_m_per_s <= 1.5);
            CHECK(report.max_speed_m_per_s > 0.7);
            CHECK(report.max_rate_rad_per_s <= 1.05);
            CHECK(report.max_rate_rad_per_s > 0.4);
            CHECK(report.path_m > 8.0);
        }
    }
}

TEST_CASE("The seed alone decides the flight") {
    const Flight a = planned("room", 7, 10.0);
    const Flight b = planned("room", 7, 10.0);
    const Flight c = planned("room", 8, 10.0);
    CHECK((a.evaluate(9.0).T_W_B.p - b.evaluate(9.0).T_W_B.p).norm() == 0.0);
    CHECK((a.evaluate(9.0).T_W_B.p - c.evaluate(9.0).T_W_B.p).norm() > 0.05);
}

TEST_CASE("Long flights keep clearance and limits, and come back to where they were") {
    for (const std::string_view name : scene_names()) {
        const Scene& scene = draft_scene(name);
        const Flight flight = planned(name, 1, 121.0);
        const FlightReport report = inspect_flight(flight, scene);
        CHECK(report.min_clearance_m >= scene.flight_volume().clearance_m);
        CHECK(report.max_speed_m_per_s <= 1.5);
        CHECK(report.max_rate_rad_per_s <= 1.05);
        CHECK(report.path_m > 40.0);
        // Of the places a second apart in the second minute, most are within 1.5 m of one of the first minute;
        // in a building, which has more to see, some.
        int revisited = 0;
        for (double t = 61.0; t <= 120.0; t += 1.0) {
            bool near = false;
            for (double s = 2.5; s <= 60.0 && !near; s += 0.5) {
                near = (flight.evaluate(t).T_W_B.p - flight.evaluate(s).T_W_B.p).norm() < 1.5;
            }
            revisited += near ? 1 : 0;
        }
        CHECK(revisited > (name == "building" ? 10 : 30));
    }
}

TEST_CASE("A minute of standing is exactly still, then the flight begins") {
    FlightPlan plan;
    plan.duration_s = 66.0;
    plan.stand_s = 60.0;
    Flight flight;
    REQUIRE(ok(plan_flight(draft_scene("room"), plan, flight)));
    for (double t = 0.0; t <= 60.0; t += 0.5) {
        CHECK(flight.evaluate(t).v_W.norm() + flight.evaluate(t).w_B.norm() < 1e-12);
    }
    double fastest = 0.0;
    for (double t = 60.0; t <= 66.0; t += 0.1) {
        fastest = std::max(fastest, flight.evaluate(t).v_W.norm());
    }
    CHECK(fastest > 0.2);
}

TEST_CASE("A hover takes off, then wanders by centimetres, slowly and nearly level") {
    for (const std::string_view name : scene_names()) {
        INFO(std::string(name));
        FlightPlan plan;
        plan.kind = FlightKind::kHover;
        plan.duration_s = 60.0;
        Flight flight;
        REQUIRE(ok(plan_flight(draft_scene(name), plan, flight)));
        const Eigen::Vector3d ground = flight.evaluate(0.0).T_W_B.p;
        CHECK(flight.evaluate(2.4).v_W.norm() < 1e-12);
        Eigen::Vector3d mean = Eigen::Vector3d::Zero();
        int count = 0;
        for (double t = 8.0; t < 60.0; t += 0.1, ++count) {
            mean += flight.evaluate(t).T_W_B.p;
        }
        mean /= count;
        CHECK((mean - ground).z() > 0.3);
        double widest = 0.0;
        double squares = 0.0;
        for (double t = 8.0; t < 60.0; t += 0.1) {
            const FlightState s = flight.evaluate(t);
            const double distance = (s.T_W_B.p - mean).norm();
            widest = std::max(widest, distance);
            squares += distance * distance / count;
            CHECK(s.v_W.norm() < 0.2);
            CHECK(s.w_B.norm() < 0.2);
            CHECK((s.T_W_B.q * Eigen::Vector3d::UnitX()).z() > 0.96);
        }
        CHECK(std::sqrt(squares) > 0.015);
        CHECK(std::sqrt(squares) < 0.04);
        CHECK(widest < 0.08);
    }
}

TEST_CASE("A turning flight holds its place, looks the same way for a while, and has looked all around in the end") {
    FlightPlan plan;
    plan.kind = FlightKind::kTurn;
    plan.duration_s = 36.0;
    Flight flight;
    REQUIRE(ok(plan_flight(draft_scene("room"), plan, flight)));
    const Eigen::Vector3d place = flight.evaluate(8.0).T_W_B.p;
    std::array<bool, 8> seen{};
    int slow = 0;
    for (double t = 6.0; t < 36.0; t += 0.1) {
        const FlightState s = flight.evaluate(t);
        CHECK((s.T_W_B.p - place).norm() < 0.15);
        CHECK(s.w_B.norm() < plan.max_rate_rad_per_s);
        slow += s.w_B.norm() < 0.2 ? 1 : 0;
        const Eigen::Vector3d ahead = s.T_W_B.q * Eigen::Vector3d::UnitZ();
        const double turn = std::atan2(ahead.y(), ahead.x()) / std::numbers::pi;
        seen[static_cast<std::size_t>(std::floor(4.0 * (turn + 1.0))) % seen.size()] = true;
    }
    CHECK(std::count(seen.begin(), seen.end(), true) == 8);
    CHECK(slow > 90);  // a third of the time
}

TEST_CASE("A closed flight ends at rest where it began, by the way it came") {
    for (const double duration_s : {30.0, 40.3}) {
        FlightPlan plan;
        plan.duration_s = duration_s;
        plan.stand_s = 1.0;
        plan.closed = true;
        Flight flight;
        REQUIRE(ok(plan_flight(draft_scene("room"), plan, flight)));
        const double end_s = flight.duration_s();
        CHECK(end_s <= duration_s);
        CHECK(end_s > duration_s - 1.0);
        const FlightState begin = flight.evaluate(0.0);
        for (const double t : {end_s - 1.0, end_s, duration_s}) {
            const FlightState s = flight.evaluate(t);
            CHECK((s.T_W_B.p - begin.T_W_B.p).norm() < 1e-12);
            CHECK(s.T_W_B.q.angularDistance(begin.T_W_B.q) < 1e-7);
            CHECK(s.v_W.norm() + s.a_W.norm() + s.w_B.norm() < 1e-12);
        }
        double widest = 0.0;
        for (double t = 0.0; t < 0.5 * end_s; t += 0.1) {
            const FlightState out = flight.evaluate(t);
            const FlightState back = flight.evaluate(end_s - t);
            CHECK((out.T_W_B.p - back.T_W_B.p).norm() < 1e-9);
            CHECK((out.v_W + back.v_W).norm() < 1e-9);
            CHECK((out.a_W - back.a_W).norm() < 1e-9);
            widest = std::max(widest, (out.T_W_B.p - begin.T_W_B.p).norm());
        }
        CHECK(widest > 1.0);
    }
}

TEST_CASE("A plan that no flight can keep is refused") {
    FlightPlan plan;
    plan.duration_s = 6.0;
    plan.max_speed_m_per_s = 0.02;  // the hover's wobble alone is faster
    Flight flight;
    CHECK(plan_flight(draft_scene("room"), plan, flight) == Status::kDegenerate);
    CHECK(flight.duration_s() == 1.0);
}

}  // namespace
}  // namespace facet::sim::flight_test
