// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/volume/surface_map.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <tuple>
#include <vector>

#include "tests/mesh/depth/stereo_scene.h"
#include "tests/support/allocation_guard.h"

namespace facet::surface_map_test {
namespace {

/// Keeps the newest vertices of each block.
struct Keeper final : SurfaceSink {
    std::map<std::tuple<std::uint32_t, int, int, int>, std::vector<SurfaceVertex>> pieces;
    void take(const SurfacePiece& piece, std::uint32_t restart) override {
        pieces[{restart, piece.at.x(), piece.at.y(), piece.at.z()}].assign(piece.vertices.begin(),
                                                                           piece.vertices.end());
    }
    std::vector<SurfaceVertex> vertices() const {
        std::vector<SurfaceVertex> all;
        for (const auto& [key, piece] : pieces) {
            all.insert(all.end(), piece.begin(), piece.end());
        }
        return all;
    }
};

MapConfig small_squares() {
    MapConfig config;
    config.square_px = 4;  // of images of 320 x 240
    config.max_blocks = 2048;
    return config;
}

const test::Surface& wall() {
    static const test::Surface surface = test::plane_surface(Eigen::Vector3d::UnitZ(), 2.0);
    return surface;
}

/// Keyframes before a surface, all looking along z, with a window of `kWindow` and `kFrames` frames after each.
struct Flight {
    static constexpr std::size_t kWindow = 8;
    static constexpr int kFrames = 5;
    test::Surface surface = wall();
    std::unique_ptr<SurfaceMap> map = std::make_unique<SurfaceMap>();
    std::unique_ptr<KeyframeView> view = std::make_unique<KeyframeView>();
    Keeper keeper;
    std::uint32_t resets = 0;
    Eigen::Vector3d error = Eigen::Vector3d::Zero();  ///< of the newest pose; those before become right

    explicit Flight(const MapConfig& config = small_squares()) {
        REQUIRE(ok(map->configure(config, test::scene_rig())));
        map->give_to(&keeper);
    }
    void visit(const Eigen::Vector3d& place) {
        const auto left = test::draw(surface, place);
        const auto right = test::draw(surface, place + Eigen::Vector3d(0.1, 0.0, 0.0));
        set_view(place);
        map->add(*view, resets, left.view(), right.view());
        for (int i = 0; i < kFrames; ++i) {
            map->advance();
        }
    }
    void set_view(const Eigen::Vector3d& place) {
        ++view->number;
        view->stamp = Timestamp{static_cast<std::int64_t>(view->number) * 100'000'000};
        view->T_W_C0.p = place + error;
        while (view->keyframes.size() >= kWindow) {
            view->keyframes.erase_at(0);
        }
        if (!view->keyframes.empty()) {
            view->keyframes.back().T_W_C0.p -= last_error_;
        }
        last_error_ = error;
        view->keyframes.push_back({view->stamp, view->T_W_C0});
    }
    void fly(int keyframes) {
        for (int k = 0; k < keyframes; ++k) {
            visit({0.15 * k, 0.02 * k, 0.0});
        }
    }

private:
    Eigen::Vector3d last_error_ = Eigen::Vector3d::Zero();
};

double share_within(const std::vector<SurfaceVertex>& vertices, double limit_m) {
    const auto good = std::ranges::count_if(
        vertices, [&](const SurfaceVertex& v) { return std::abs(static_cast<double>(v.p_W.z()) - 2.0) < limit_m; });
    return static_cast<double>(good) / static_cast<double>(vertices.size());
}

TEST_CASE("a wall flown along is a surface, where the poses that settle say") {
    Flight flight;
    flight.error = {0.0, 0.0, 0.1};
    flight.fly(9);
    flight.error.setZero();  // nothing would correct the last one
    flight.visit({1.35, 0.18, 0.0});
    CHECK(flight.map->counters().keyframes == 10);
    CHECK(flight.map->counters().integrated >= 3);
    flight.map->finish();
    const MapCounters& counters = flight.map->counters();
    CHECK(counters.integrated == 10);
    CHECK(counters.skipped == 0);
    CHECK(counters.settled == 10);
    CHECK(counters.moved_most_m == 0.0);
    const auto vertices = flight.keeper.vertices();
    REQUIRE(vertices.size() > 1000);
    CHECK(share_within(vertices, 0.01) > 0.8);
    CHECK(share_within(vertices, 0.03) > 0.9);
    for (const SurfaceVertex& v : vertices) {
        CHECK(v.normal_W.norm() == Approx(1.0F).margin(1e-4));
        CHECK((v.grey > 0.0F && v.grey < 255.0F));
    }
}

TEST_CASE("no heap after configure, and the same work gives the same surface") {
    Flight first;
    first.fly(7);
    first.map->finish();
    Flight second;
    second.map->give_to(nullptr);  // the keeper uses the heap
    for (int k = 0; k < 7; ++k) {
        const Eigen::Vector3d place(0.15 * k, 0.02 * k, 0.0);
        const auto left = test::draw(wall(), place);
        const auto right = test::draw(wall(), place + Eigen::Vector3d(0.1, 0.0, 0.0));
        second.set_view(place);
        const test::AllocationGuard guard;
        second.map->add(*second.view, 0, left.view(), right.view());
        for (int i = 0; i < Flight::kFrames; ++i) {
            second.map->advance();
        }
        const std::uint64_t allocations = guard.allocations();
        CHECK(allocations == 0);
    }
    {
        const test::AllocationGuard guard;
        second.map->finish();
        const std::uint64_t allocations = guard.allocations();
        CHECK(allocations == 0);
    }
    second.map->give_to(&second.keeper);
    second.map->finish();
    const auto a = first.keeper.vertices();
    const auto b = second.keeper.vertices();
    REQUIRE(a.size() == b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        CHECK((a[i].p_W == b[i].p_W && a[i].grey == b[i].grey && a[i].last == b[i].last));
    }
}

TEST_CASE("a slice is bounded, and who has too little time leaves keyframes out") {
    MapConfig config = small_squares();
    config.steps_per_frame = 60;
    Flight flight(config);
    for (int k = 0; k < 60; ++k) {
        flight.visit({0.02 * k, 0.0, 0.0});
    }
    const MapCounters& counters = flight.map->counters();
    CHECK(counters.keyframes + counters.skipped == 60);
    CHECK(counters.skipped > 20);
    CHECK(counters.integrated < 5);
    flight.map->finish();
    CHECK(counters.integrated == counters.keyframes);
}

TEST_CASE("when blocks are used up the farthest leave, and their surface stays with who was given it") {
    MapConfig config = small_squares();
    config.max_blocks = 256;
    Flight flight(config);
    flight.fly(40);
    flight.map->finish();
    CHECK(flight.map->volume().block_count() <= 256);
    CHECK(flight.map->volume().left() > 0);
    CHECK(flight.keeper.pieces.size() > flight.map->volume().block_count() / 2);
    const auto [least, most] =
        std::ranges::minmax(flight.keeper.vertices(), {}, [](const auto& v) { return v.p_W.x(); });
    CHECK(least.p_W.x() < 0.0F);
    CHECK(most.p_W.x() > 6.0F);
}

TEST_CASE("what cannot be used is left out") {
    Flight flight;
    const auto image = test::draw(wall(), {0.0, 0.0, 0.0});
    flight.set_view({0.0, 0.0, 0.0});
    flight.map->add(*flight.view, 0, {}, {});
    flight.map->add(*flight.view, 0, image.view(), {});
    ImageView other = image.view();
    other.height /= 2;
    flight.map->add(*flight.view, 0, other, image.view());
    flight.view->is_exchanged = true;
    flight.map->add(*flight.view, 0, image.view(), image.view());
    flight.view->is_exchanged = false;
    flight.view->T_W_C0.p.x() = std::numeric_limits<double>::quiet_NaN();
    flight.map->add(*flight.view, 0, image.view(), image.view());
    CHECK(flight.map->counters().keyframes == 0);
    CHECK(flight.map->counters().skipped == 5);
    flight.map->finish();
    CHECK(flight.map->volume().block_count() == 0);
}

TEST_CASE("landmarks that are NaN, or lie elsewhere, are ignored") {
    Flight flight;
    LandmarkSnapshot landmark;
    landmark.is_tracked = true;
    for (const float depth :
         {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 1e-30F}) {
        for (const float u : {-1e9F, 50.0F, 1e9F, std::numeric_limits<float>::quiet_NaN()}) {
            landmark.depth_m = depth;
            landmark.left_px = {u, 50.0F};
            flight.view->landmarks.push_back(landmark);
        }
    }
    flight.fly(6);
    flight.map->finish();
    const auto vertices = flight.keeper.vertices();
    REQUIRE(vertices.size() > 1000);
    CHECK(share_within(vertices, 0.03) > 0.9);
}

TEST_CASE("after a restart of the estimate the map restarts") {
    Flight flight;
    flight.fly(7);
    REQUIRE(flight.map->volume().block_count() > 0);
    flight.resets = 1;
    flight.visit({0.0, 0.0, 0.0});
    CHECK(flight.map->counters().restarts == 1);
    CHECK(flight.map->volume().block_count() == 0);
    CHECK(!flight.keeper.pieces.empty());  // what was given away before stays
}

TEST_CASE("parameters out of range are refused") {
    SurfaceMap map;
    MapConfig config;
    config.square_px = 1;
    CHECK(map.configure(config, test::scene_rig()) == Status::kInvalidArgument);
}

}  // namespace
}  // namespace facet::surface_map_test
