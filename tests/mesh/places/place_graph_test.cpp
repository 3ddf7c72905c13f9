// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/places/place_graph.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <random>

#include "tests/support/allocation_guard.h"

namespace facet::place_graph_test {
namespace {

/// Stations on a circle of 5 m, flown round twice, with odometry whose heading drifts.
struct Circle {
    static constexpr int kRound = 40;
    std::unique_ptr<PlaceGraph> graph = std::make_unique<PlaceGraph>();
    double drift_rad = 0.01;  ///< a step

    Circle() { graph->configure(); }

    static YawPose truth(int i) {
        const double angle = 2.0 * std::numbers::pi * i / kRound;
        return {wrapped(angle), {5.0 * std::sin(angle), 5.0 - 5.0 * std::cos(angle), 0.0}};
    }
    PlaceGraph::Relation odometry(int i) const {
        YawPose step = truth(i - 1).inverse() * truth(i);
        step.yaw += drift_rad;
        return {step, Eigen::Vector4d(1e4, 1e6, 1e6, 1e6).asDiagonal()};
    }
    void fly_to(int count) {
        for (int i = static_cast<int>(graph->size()); i < count; ++i) {
            PlaceGraph::Node node;
            if (i > 0) {
                node.before = odometry(i);
                node.T_M = graph->node(static_cast<std::size_t>(i) - 1).T_M * node.before.T_a_b;
            }
            graph->add_node(node);
        }
    }
    void close(int a, int b) {
        graph->add_loop(static_cast<std::size_t>(a), static_cast<std::size_t>(b),
                        {truth(a).inverse() * truth(b), 1e6 * Eigen::Matrix4d::Identity()});
    }
    void relax() {
        graph->begin();
        while (graph->is_busy()) {
            graph->advance();
        }
    }
    double worst() const {
        double worst = 0.0;
        for (std::size_t i = 0; i < graph->size(); ++i) {
            worst = std::max(worst, (graph->node(i).T_M.p - truth(static_cast<int>(i)).p).norm());
        }
        return worst;
    }
};

}  // namespace

TEST_CASE("a loop takes the drift out of the whole path") {
    Circle circle;
    circle.fly_to(Circle::kRound + 1);
    CHECK(circle.worst() > 1.0);
    circle.close(0, Circle::kRound);
    circle.relax();
    CHECK(circle.worst() < 0.05);
    // The drift is spread over the steps.
    for (int i = 1; i <= Circle::kRound; ++i) {
        const auto k = static_cast<std::size_t>(i);
        const YawPose step = circle.graph->node(k - 1).T_M.inverse() * circle.graph->node(k).T_M;
        CHECK(std::abs(wrapped(step.yaw - (Circle::truth(i - 1).inverse() * Circle::truth(i)).yaw)) < 1e-3);
    }
}

TEST_CASE("without loops, and with loops that agree, nothing moves") {
    Circle circle;
    circle.drift_rad = 0.0;
    circle.fly_to(60);
    circle.close(2, 42);
    circle.close(10, 50);
    circle.relax();
    CHECK(circle.worst() < 1e-9);
}

TEST_CASE("stations that come while the graph is relaxed follow it, and slices take no heap") {
    Circle circle;
    circle.fly_to(Circle::kRound + 1);
    circle.close(0, Circle::kRound);
    const test::AllocationGuard guard;
    circle.graph->begin();
    circle.graph->advance();
    circle.fly_to(Circle::kRound + 6);
    while (circle.graph->is_busy()) {
        circle.graph->advance();
    }
    const std::uint64_t allocations = guard.allocations();
    CHECK(allocations == 0);
    CHECK((circle.graph->node(Circle::kRound + 5).T_M.p - Circle::truth(Circle::kRound + 5).p).norm() < 0.2);
}

TEST_CASE("a path that floats is drawn to fixed poses as a whole") {
    Circle circle;
    circle.drift_rad = 0.0;
    circle.fly_to(20);
    const YawPose away{0.4, {3.0, -1.0, 0.5}};
    circle.graph->move_from(0, away);
    circle.graph->set_floating(true);
    for (const int i : {3, 15}) {
        circle.graph->add_fixed(Circle::truth(i), static_cast<std::size_t>(i), {{}, 1e6 * Eigen::Matrix4d::Identity()});
    }
    circle.relax();
    circle.relax();
    CHECK(circle.worst() < 1e-4);
}

TEST_CASE("odometry over a node that is taken out is what it was over the two steps") {
    Circle circle;
    circle.fly_to(Circle::kRound + 1);
    circle.close(0, Circle::kRound);
    circle.close(5, 30);
    const YawPose last = circle.graph->node(Circle::kRound).T_M;
    circle.graph->remove(20);
    circle.graph->remove(5);  // and its loop
    CHECK(circle.graph->size() == Circle::kRound - 1U);
    CHECK(circle.graph->loop_count() == 1U);
    CHECK(circle.graph->node(circle.graph->size() - 1).T_M.box_minus_to(last).norm() < 1e-12);
    circle.relax();
    CHECK((circle.graph->node(circle.graph->size() - 1).T_M.p - Circle::truth(Circle::kRound).p).norm() < 0.01);
    CHECK((circle.graph->node(10).T_M.p - Circle::truth(11).p).norm() < 0.05);
}

TEST_CASE("two hundred loops in an hour of noise bring the path to its least error") {
    std::mt19937 random(3);
    std::normal_distribution<double> noise;
    PlaceGraph graph;
    graph.configure();
    const auto truth = [](int i) { return Circle::truth(i); };
    constexpr int kCount = 1500;
    for (int i = 0; i < kCount; ++i) {
        PlaceGraph::Node node;
        if (i > 0) {
            YawPose step = truth(i - 1).inverse() * truth(i);
            step =
                step.box_plus({2e-3 * noise(random), 3e-3 * noise(random), 3e-3 * noise(random), 3e-3 * noise(random)});
            node.before = {step, Eigen::Vector4d(2.5e5, 1.1e5, 1.1e5, 1.1e5).asDiagonal()};
            node.T_M = graph.node(static_cast<std::size_t>(i) - 1).T_M * step;
        }
        graph.add_node(node);
    }
    const auto error = [&](std::size_t i) { return (graph.node(i).T_M.p - truth(static_cast<int>(i)).p).norm(); };
    CHECK(error(kCount - 1) > 0.1);
    for (int i = 80; i < kCount; i += 7) {
        const int a = i % Circle::kRound;
        const YawPose z =
            (truth(a).inverse() * truth(i))
                .box_plus({1e-3 * noise(random), 2e-3 * noise(random), 2e-3 * noise(random), 2e-3 * noise(random)});
        graph.add_loop(static_cast<std::size_t>(a), static_cast<std::size_t>(i),
                       {z, Eigen::Vector4d(1e6, 2.5e5, 2.5e5, 2.5e5).asDiagonal()});
    }
    for (int i = 0; i < 3; ++i) {
        graph.begin();
        while (graph.is_busy()) {
            graph.advance();
        }
    }
    for (std::size_t i = 0; i < kCount; i += 50) {
        CHECK(error(i) < 0.04);
    }
}

}  // namespace facet::place_graph_test
