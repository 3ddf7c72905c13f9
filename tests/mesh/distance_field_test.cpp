// SPDX-License-Identifier: BSD-2-Clause
// The distance field against a search through all targets, and what it promises between the cells' centres.
#include "mesh/distance_field.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "tests/mesh/mesh_world.h"
#include "tests/support/allocation_guard.h"

namespace facet::distance_field_test {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr int kX = OccupancyGrid::kGridX;
constexpr int kY = OccupancyGrid::kGridY;
constexpr int kZ = OccupancyGrid::kGridZ;
constexpr double kCell_m = 0.1;

/// States that a test sets cell by cell; all others are free.
struct Cells {
    Vector3i low;
    std::vector<std::uint8_t> packed = std::vector<std::uint8_t>(OccupancyGrid::kPackedBytes, 0x55);
    std::vector<Vector3i> targets;  ///< absolute

    explicit Cells(const Vector3i& lowest) : low(lowest) {}

    /// @param code  0 unknown, 2 occupied
    void set(const Vector3i& c, unsigned code) {
        const auto place =
            static_cast<std::size_t>(((c.z() & (kZ - 1)) * kY + (c.y() & (kY - 1))) * kX + (c.x() & (kX - 1)));
        std::uint8_t& four = packed[place / 4];
        const unsigned shift = 2 * (place % 4);
        four = static_cast<std::uint8_t>((four & ~(3U << shift)) | (code << shift));
        targets.push_back(c);
    }
    /// Squared distance to the nearest target, in cells.
    int nearest(const Vector3i& c) const {
        int least = 1 << 30;
        for (const Vector3i& t : targets) {
            least = std::min(least, (t - c).squaredNorm());
        }
        return least;
    }
    Status measure(DistanceField& field, double reach_m, FieldTarget target) const {
        return field.update(std::span<const std::uint8_t, OccupancyGrid::kPackedBytes>(packed), low, kCell_m, reach_m,
                            target);
    }
};

Vector3d centre_of(const Vector3i& c) { return kCell_m * (c.cast<double>().array() + 0.5).matrix(); }

/// Scattered targets in a grid that has rolled to an odd place.
Cells scattered(int count, unsigned code, std::uint32_t seed) {
    Cells cells({-77, 1003, -29});
    std::mt19937 random(seed);
    const auto draw = [&](int size) { return static_cast<int>(random() % static_cast<std::uint32_t>(size)); };
    for (int i = 0; i < count; ++i) {
        cells.set(cells.low + Vector3i(draw(kX), draw(kY), draw(kZ)), code);
    }
    return cells;
}

TEST_CASE("distances between centres, and the nearest obstacle, are those that a search finds") {
    const auto field = std::make_unique<DistanceField>();
    for (const int count : {1, 40, 3000}) {
        const Cells cells = scattered(count, 2, static_cast<std::uint32_t>(count));
        REQUIRE(ok(cells.measure(*field, 2.0, FieldTarget::kOccupied)));
        CHECK(field->reach_m() == Approx(2.0));
        std::mt19937 random(7);
        int within = 0;
        for (int i = 0; i < 2000; ++i) {
            // Half of them next to an obstacle: far from the few ones there is nothing to compare.
            Vector3i c = cells.low + Vector3i(static_cast<int>(random() % kX), static_cast<int>(random() % kY),
                                              static_cast<int>(random() % kZ));
            if (i % 2 == 0) {
                const Vector3i off(static_cast<int>(random() % 31) - 15, static_cast<int>(random() % 31) - 15,
                                   static_cast<int>(random() % 31) - 15);
                c = (cells.targets[random() % cells.targets.size()] + off)
                        .cwiseMax(cells.low)
                        .cwiseMin(cells.low + Vector3i(kX - 1, kY - 1, kZ - 1));
            }
            const int square = cells.nearest(c);
            const FieldPoint point = field->at(centre_of(c));
            REQUIRE(point.has_target == (square <= 20 * 20));
            REQUIRE(point.distance_m == Approx(std::min(kCell_m * std::sqrt(square), 2.0)).margin(1e-9));
            if (point.has_target) {
                ++within;
                REQUIRE((point.target_W - centre_of(c)).norm() == Approx(kCell_m * std::sqrt(square)).margin(1e-9));
                REQUIRE(point.target == Space::kOccupied);
                REQUIRE(cells.nearest((point.target_W / kCell_m).array().floor().cast<int>()) == 0);
            }
        }
        CHECK(within > 500);
    }
}

TEST_CASE("between the centres the distance is interpolated, and the gradient is its slope") {
    const Cells cells = scattered(400, 2, 5);
    const auto field = std::make_unique<DistanceField>();
    REQUIRE(ok(cells.measure(*field, 2.0, FieldTarget::kOccupied)));
    std::mt19937 random(11);
    const auto draw = [&](int size) {
        return 2.0 * kCell_m + (size - 4) * kCell_m * static_cast<double>(random()) / 4294967296.0;
    };
    int compared = 0;
    for (int i = 0; i < 1000; ++i) {
        const Vector3d p = kCell_m * cells.low.cast<double>() + Vector3d(draw(kX), draw(kY), draw(kZ));
        double exact = 1e9;
        for (const Vector3i& t : cells.targets) {
            exact = std::min(exact, (centre_of(t) - p).norm());
        }
        const FieldPoint point = field->at(p);
        if (exact > 1.8) {
            continue;
        }
        ++compared;
        CHECK(std::abs(point.distance_m - exact) < std::sqrt(3.0) * 0.5 * kCell_m);
        constexpr double kStep = 1e-6;
        for (int axis = 0; axis < 3; ++axis) {
            const Vector3d step = kStep * Vector3d::Unit(axis);
            const double slope = (field->at(p + step).distance_m - field->at(p - step).distance_m) / (2.0 * kStep);
            CHECK(point.gradient[axis] == Approx(slope).margin(1e-5));
        }
    }
    CHECK(compared > 500);
}

TEST_CASE("what is not free is kept away from, too, and so is what lies outside the grid") {
    const Cells cells = scattered(30, 0, 3);
    const auto field = std::make_unique<DistanceField>();
    const Vector3i middle = cells.low + Vector3i(kX / 2, kY / 2, kZ / 2);
    REQUIRE(ok(cells.measure(*field, 2.0, FieldTarget::kOccupied)));
    CHECK_FALSE(field->at(centre_of(cells.targets.front())).has_target);
    REQUIRE(ok(cells.measure(*field, 2.2, FieldTarget::kNotFree)));
    const FieldPoint at = field->at(centre_of(cells.targets.front()));
    CHECK(at.has_target);
    CHECK(at.distance_m == 0.0);
    CHECK(at.space == Space::kUnknown);
    CHECK(at.target == Space::kUnknown);
    // The border is nearest here: eight cells from the outermost ones.
    const Vector3i near_border(cells.low.x() + 8, middle.y(), middle.z());
    CHECK(field->at(centre_of(near_border)).distance_m <= 0.8 + 1e-9);
    CHECK(field->at(centre_of(cells.low)).distance_m == 0.0);
    const FieldPoint outside = field->at(centre_of(cells.low - Vector3i(1, 0, 0)));
    CHECK(outside.space == Space::kUnknown);
    CHECK(outside.distance_m == field->reach_m());
    CHECK(outside.gradient.norm() == 0.0);
}

TEST_CASE("the field of a grid leads away from the wall that the grid has seen, without heap") {
    auto mesher = test::make_mesher();
    const auto grid = std::make_unique<OccupancyGrid>();
    test::MeshWorld world;
    world.wall(1.6, 1.0, 0.25, [](double, double) { return 2.05; });
    const Se3 here = test::looking_along_x({0.03, 0.03, 0.03});
    for (int k = 0; k < 4; ++k) {
        auto view = test::view_of(world, here, 10 + k);
        view->stamp = Timestamp{} + Duration::from_seconds(10.0 + 0.25 * k);
        view->oldest_stamp = {0};
        mesher->update(*view, {});
        grid->update(*view, mesher->mesh(), static_cast<std::uint32_t>(mesher->counters().updates));
    }
    const auto field = std::make_unique<DistanceField>();
    const test::AllocationGuard guard;
    REQUIRE(ok(field->update(*grid, 2.0, FieldTarget::kOccupied)));
    const FieldPoint before = field->at({1.0, 0.03, 0.03});
    CHECK(guard.allocations() == 0);
    CHECK(before.space == Space::kFree);
    CHECK(before.distance_m == Approx(1.05).margin(0.06));
    CHECK(before.gradient.x() == Approx(-1.0).margin(0.1));
    CHECK(std::abs(before.gradient.y()) < 0.3);
    REQUIRE(before.has_target);
    // Certainty and age are the grid's.
    const GridState wall = grid->at(before.target_W);
    CHECK(wall.space == Space::kOccupied);
    CHECK(wall.certainty > 0.9F);
    CHECK(wall.age_s == 0.0F);
    // What is beyond the wall is far from it, but not known.
    CHECK(field->at({3.0, 0.03, 0.03}).space == Space::kUnknown);
}

TEST_CASE("a field that nobody has measured knows nothing, and bad sizes change nothing") {
    const auto field = std::make_unique<DistanceField>();
    CHECK(field->reach_m() == 0.0);
    CHECK_FALSE(field->at({0.0, 0.0, 0.0}).has_target);
    Cells cells({-64, -64, -32});
    cells.set({0, 0, 0}, 2);
    REQUIRE(ok(cells.measure(*field, 100.0, FieldTarget::kOccupied)));
    CHECK(field->reach_m() == Approx(DistanceField::kMaxReach * kCell_m));
    CHECK(cells.measure(*field, -1.0, FieldTarget::kOccupied) == Status::kInvalidArgument);
    CHECK(cells.measure(*field, std::nan(""), FieldTarget::kOccupied) == Status::kInvalidArgument);
    CHECK(field->at({0.25, 0.05, 0.05}).distance_m == Approx(0.2));
    CHECK(field->at({std::nan(""), 0.0, 0.0}).space == Space::kUnknown);
    field->clear();
    CHECK_FALSE(field->at({0.25, 0.05, 0.05}).has_target);
}

}  // namespace
}  // namespace facet::distance_field_test
