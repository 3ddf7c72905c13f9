// SPDX-License-Identifier: BSD-2-Clause
// Points anywhere, on lines and on grids: the triangulation is whole whatever they are.
#include <cmath>
#include <memory>
#include <vector>

#include "mesh/delaunay.h"
#include "tests/fuzz/fuzz_input.h"

using namespace facet;

namespace {

/// The three forms that points take: any number, a small grid, and floats whose last bits alone differ.
Eigen::Vector2d take_point(test::FuzzInput& input, int form) {
    if (form == 0) {
        const auto x = input.take<double>();
        const auto y = input.take<double>();
        return {x, y};
    }
    const auto x = input.take<std::int8_t>();
    const auto y = input.take<std::int8_t>();
    return form == 1 ? Eigen::Vector2d(x, y) : Eigen::Vector2d(1.0 + x * 0x1p-52, 1.0 + y * 0x1p-52);
}

void check(const Delaunay& delaunay, const std::vector<Eigen::Vector2d>& points) {
    const auto triangles = delaunay.triangles();
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        const Triangle& triangle = triangles[t];
        for (std::size_t k = 0; k < 3; ++k) {
            test::require(triangle.point[k] < points.size());
            test::require(triangle.point[k] != triangle.point[(k + 1) % 3]);
            const int next = triangle.neighbour[k];
            test::require(next < static_cast<int>(triangles.size()));
            if (next >= 0) {
                const auto& back = triangles[static_cast<std::size_t>(next)].neighbour;
                test::require(std::count(back.begin(), back.end(), static_cast<std::int16_t>(t)) > 0);
            }
        }
    }
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    test::FuzzInput input(data, size);
    const int form = input.take<std::uint8_t>() % 3;
    const std::size_t later = input.take<std::uint8_t>();
    std::vector<Eigen::Vector2d> points;
    while (!input.empty() && points.size() <= static_cast<std::size_t>(kMaxMeshPoints)) {
        points.push_back(take_point(input, form));
    }
    static const auto delaunay = std::make_unique<Delaunay>();
    const std::size_t first = points.size() - std::min(later, points.size());
    const Status status = delaunay->triangulate({points.data(), first});
    check(*delaunay, points);
    if (ok(status)) {
        static_cast<void>(delaunay->insert({points.data(), points.size()}));
        check(*delaunay, points);
    }
    return 0;
}
