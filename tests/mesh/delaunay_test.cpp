// SPDX-License-Identifier: BSD-2-Clause
// Properties of the triangulation, each checked by brute force with exact integers.
#include "mesh/delaunay.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <span>
#include <vector>

#include "tests/support/allocation_guard.h"

namespace facet::delaunay_test {
namespace {

using Eigen::Vector2d;
using Points = std::vector<Vector2d>;
using Wide = __int128;

// All test points are multiples of 1/64 below 4096: 18-bit integers, whose determinants fit 128 bits.
constexpr double kUnit = 64.0;

Wide integer(double x) {
    const double scaled = x * kUnit;
    REQUIRE(scaled == std::floor(scaled));
    return static_cast<Wide>(scaled);
}

Wide turn(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
    return (integer(a.x()) - integer(c.x())) * (integer(b.y()) - integer(c.y())) -
           (integer(a.y()) - integer(c.y())) * (integer(b.x()) - integer(c.x()));
}

bool inside_circle(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d) {
    const Vector2d* p[3] = {&a, &b, &c};
    Wide x[3];
    Wide y[3];
    Wide l[3];
    for (int i = 0; i < 3; ++i) {
        x[i] = integer(p[i]->x()) - integer(d.x());
        y[i] = integer(p[i]->y()) - integer(d.y());
        l[i] = x[i] * x[i] + y[i] * y[i];
    }
    return l[0] * (x[1] * y[2] - x[2] * y[1]) + l[1] * (x[2] * y[0] - x[0] * y[2]) +
               l[2] * (x[0] * y[1] - x[1] * y[0]) >
           0;
}

/// Twice the area of the convex hull, and the number of distinct points on its border, by Andrew's monotone chain.
Wide hull_area(Points points, std::size_t& border) {
    const auto less = [](const Vector2d& a, const Vector2d& b) {
        return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
    };
    std::sort(points.begin(), points.end(), less);
    points.erase(std::unique(points.begin(), points.end()), points.end());
    Points hull;
    for (int side = 0; side < 2; ++side) {
        const std::size_t start = hull.size();
        for (const Vector2d& p : points) {
            while (hull.size() >= start + 2 && turn(hull[hull.size() - 2], hull.back(), p) < 0) {
                hull.pop_back();
            }
            hull.push_back(p);
        }
        hull.pop_back();
        std::reverse(points.begin(), points.end());
    }
    Wide area = 0;
    for (std::size_t i = 2; i < hull.size(); ++i) {
        area += turn(hull[0], hull[i - 1], hull[i]);
    }
    border = hull.size();
    return area;
}

std::set<std::pair<double, double>> distinct(const Points& points) {
    std::set<std::pair<double, double>> set;
    for (const Vector2d& p : points) {
        set.insert({p.x(), p.y()});
    }
    return set;
}

/// Every property that makes a set of triangles the Delaunay triangulation of the points.
void check_delaunay(const Delaunay& delaunay, const Points& points) {
    const std::span<const Triangle> triangles = delaunay.triangles();
    const std::size_t count = distinct(points).size();
    CHECK(delaunay.duplicates() == static_cast<int>(points.size() - count));
    std::size_t border = 0;
    const Wide hull = points.empty() ? 0 : hull_area(points, border);
    if (hull == 0) {
        CHECK(triangles.empty());
        return;
    }
    REQUIRE(triangles.size() == 2 * count - 2 - border);  // Euler
    Wide area = 0;
    std::map<std::pair<int, int>, int> sides;  // directed side -> triangle
    std::set<int> used;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        const auto& p = triangles[t].point;
        REQUIRE(turn(points[p[0]], points[p[1]], points[p[2]]) > 0);
        area += turn(points[p[0]], points[p[1]], points[p[2]]);
        for (std::size_t k = 0; k < 3; ++k) {
            REQUIRE(sides.insert({{p[k], p[(k + 1) % 3]}, static_cast<int>(t)}).second);
            used.insert(p[k]);
        }
        bool is_empty = true;
        for (const Vector2d& q : points) {
            is_empty = is_empty && !inside_circle(points[p[0]], points[p[1]], points[p[2]], q);
        }
        REQUIRE(is_empty);
    }
    CHECK(used.size() == count);
    CHECK(area == hull);  // positive triangles that share no directed side and fill the hull's area do not overlap
    for (const auto& [side, t] : sides) {
        const auto& p = triangles[static_cast<std::size_t>(t)].point;
        const auto k = static_cast<std::size_t>(std::find(p.begin(), p.end(), side.first) - p.begin());
        const auto other = sides.find({side.second, side.first});
        REQUIRE(triangles[static_cast<std::size_t>(t)].neighbour[k] == (other == sides.end() ? -1 : other->second));
    }
}

double snap(double x) { return std::round(x * kUnit) / kUnit; }

Points random_points(int count, unsigned seed, double width = 752.0, double height = 480.0) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> u(0.0, width);
    std::uniform_real_distribution<double> v(0.0, height);
    Points points;
    for (int i = 0; i < count; ++i) {
        const double x = snap(u(random));
        points.push_back({x, snap(v(random))});
    }
    return points;
}

void triangulate_and_check(const Points& points) {
    const auto delaunay = std::make_unique<Delaunay>();
    REQUIRE(ok(delaunay->triangulate(points)));
    check_delaunay(*delaunay, points);
}

TEST_CASE("random points of every number up to the capacity are triangulated") {
    for (int n = 0; n < 40; ++n) {
        triangulate_and_check(random_points(n, static_cast<unsigned>(n)));
    }
    for (const int n : {64, 100, 200, 300, 511, 512, kMaxMeshPoints}) {
        triangulate_and_check(random_points(n, 7U * static_cast<unsigned>(n)));
    }
}

TEST_CASE("points with few distinct coordinates: duplicates, lines and circles in plenty") {
    for (unsigned seed = 0; seed < 60; ++seed) {
        const Points fine = random_points(3 + static_cast<int>(seed), seed, 6.0, 6.0);
        Points coarse;
        for (const Vector2d& p : fine) {
            coarse.push_back(p.array().floor());
        }
        triangulate_and_check(coarse);
    }
}

TEST_CASE("grids, lines, circles and single points") {
    Points grid;
    for (int i = 0; i < 22; ++i) {
        for (int j = 0; j < 22; ++j) {
            grid.push_back({20.0 * i, 20.0 * j});
        }
    }
    triangulate_and_check(grid);
    Points tilted;
    for (const Vector2d& p : grid) {
        tilted.push_back({3.0 * p.x() - 4.0 * p.y() + 2000.0, 4.0 * p.x() + 3.0 * p.y()});
    }
    triangulate_and_check(tilted);
    Points line;
    for (int i = 0; i < 100; ++i) {
        line.push_back({7.0 * ((i * 37) % 100), 3.0 * ((i * 37) % 100)});
    }
    triangulate_and_check(line);
    line.push_back({1.0, 400.0});
    triangulate_and_check(line);
    triangulate_and_check(Points(100, Vector2d(3.0, 4.0)));
    Points circle;  // Pythagorean: all on one circle exactly
    for (const auto& [x, y] : {std::pair{25, 0}, {24, 7}, {20, 15}, {15, 20}, {7, 24}}) {
        for (const int sx : {-1, 1}) {
            for (const int sy : {-1, 1}) {
                circle.push_back({500.0 + sx * x, 500.0 + sy * y});
                circle.push_back({500.0 + sx * y, 500.0 + sy * x});
            }
        }
    }
    triangulate_and_check(circle);
}

std::set<std::vector<std::pair<double, double>>> as_coordinates(const Delaunay& delaunay, const Points& points) {
    std::set<std::vector<std::pair<double, double>>> set;
    for (const Triangle& t : delaunay.triangles()) {
        std::vector<std::pair<double, double>> corners;
        for (const std::uint16_t p : t.point) {
            corners.push_back({points[p].x(), points[p].y()});
        }
        std::sort(corners.begin(), corners.end());
        set.insert(corners);
    }
    return set;
}

TEST_CASE("the order of the points does not matter, not even on a grid") {
    Points points = random_points(150, 3);
    for (int i = 0; i < 12; ++i) {
        for (int j = 0; j < 12; ++j) {
            points.push_back({1000.0 + 16.0 * i, 16.0 * j});
        }
    }
    const auto delaunay = std::make_unique<Delaunay>();
    REQUIRE(ok(delaunay->triangulate(points)));
    const auto first = as_coordinates(*delaunay, points);
    std::mt19937 random(5);
    for (int i = 0; i < 10; ++i) {
        std::shuffle(points.begin(), points.end(), random);
        REQUIRE(ok(delaunay->triangulate(points)));
        CHECK(as_coordinates(*delaunay, points) == first);
    }
}

/// Triangulates the corners of a rectangle and `first` of the points, and then inserts the others.
void insert_and_check(Delaunay& delaunay, const Points& inside, std::size_t first, double low, double high) {
    Points points{{low, low}, {high, low}, {low, high}, {high, high}};
    points.insert(points.end(), inside.begin(), inside.end());
    REQUIRE(ok(delaunay.triangulate(std::span(points).first(4 + first))));
    REQUIRE(ok(delaunay.insert(points)));
    check_delaunay(delaunay, points);
}

TEST_CASE("points that are inserted later are triangulated with the others") {
    const auto delaunay = std::make_unique<Delaunay>();
    for (unsigned seed = 0; seed < 20; ++seed) {
        insert_and_check(*delaunay, random_points(10 + 9 * static_cast<int>(seed), seed), 5 * seed, -1.0, 800.0);
    }
    insert_and_check(*delaunay, random_points(508, 4), 0, -1.0, 800.0);
    Points points = random_points(300, 8);
    REQUIRE(ok(delaunay->triangulate(points)));
    const auto whole = as_coordinates(*delaunay, points);
    std::stable_partition(points.begin(), points.end(), [](const Vector2d& p) {
        return p.x() < 50.0 || p.x() > 700.0 || p.y() < 50.0 || p.y() > 430.0;  // the border before the middle
    });
    REQUIRE(ok(delaunay->triangulate(std::span(points).first(200))));
    REQUIRE(ok(delaunay->insert(points)));
    CHECK(as_coordinates(*delaunay, points) == whole);
}

TEST_CASE("points are inserted on sides, on circles and twice") {
    const auto delaunay = std::make_unique<Delaunay>();
    for (unsigned seed = 0; seed < 60; ++seed) {
        Points coarse;
        for (const Vector2d& p : random_points(3 + static_cast<int>(seed), seed, 6.0, 6.0)) {
            coarse.push_back(p.array().floor());
        }
        insert_and_check(*delaunay, coarse, seed / 3, -2.0, 8.0);
    }
}

TEST_CASE("points outside the hull or on its border are not inserted") {
    const auto delaunay = std::make_unique<Delaunay>();
    Points points{{0.0, 0.0}, {10.0, 0.0}, {0.0, 10.0}, {10.0, 10.0}, {4.0, 3.0}};
    REQUIRE(ok(delaunay->triangulate(points)));
    const auto before = as_coordinates(*delaunay, points);
    points.insert(points.end(), {{11.0, 5.0}, {5.0, 0.0}, {-3.0, -3.0}, {20.0, 0.0}});
    REQUIRE(ok(delaunay->insert(points)));
    CHECK(as_coordinates(*delaunay, points) == before);
    points.push_back({6.0, 6.0});
    REQUIRE(ok(delaunay->insert(points)));
    CHECK(delaunay->triangles().size() == before.size() + 2);
    CHECK(delaunay->insert(std::span(points).first(3)) == Status::kInvalidArgument);
    points.push_back({std::numeric_limits<double>::quiet_NaN(), 1.0});
    CHECK(delaunay->insert(points) == Status::kInvalidArgument);
    CHECK(delaunay->insert(Points(kMaxMeshPoints + 1, Vector2d(5.0, 6.0))) == Status::kFull);
    CHECK(delaunay->triangles().size() == before.size() + 2);
    const Points line{{0.0, 0.0}, {1.0, 1.0}, {2.0, 2.0}, {1.0, 0.0}};
    REQUIRE(ok(delaunay->triangulate(std::span(line).first(3))));
    REQUIRE(ok(delaunay->insert(line)));
    CHECK(delaunay->triangles().empty());
}

TEST_CASE("too many points and values that are no coordinates are refused") {
    const auto delaunay = std::make_unique<Delaunay>();
    CHECK(delaunay->triangulate(random_points(kMaxMeshPoints + 1, 1)) == Status::kFull);
    CHECK(delaunay->triangles().empty());
    for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e10}) {
        Points points = random_points(10, 1);
        points[4].y() = bad;
        CHECK(delaunay->triangulate(points) == Status::kInvalidArgument);
        CHECK(delaunay->triangles().empty());
    }
}

TEST_CASE("triangulation needs no heap") {
    const Points points = random_points(300, 11);
    const auto delaunay = std::make_unique<Delaunay>();
    const test::AllocationGuard guard;
    const Status status = delaunay->triangulate(points);
    const std::uint64_t allocations = guard.allocations();
    REQUIRE(ok(status));
    CHECK(allocations == 0);
}

}  // namespace
}  // namespace facet::delaunay_test
