// SPDX-License-Identifier: BSD-2-Clause
#include "app/view/live_surface.h"

#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <vector>

namespace facet::live_surface_test {
namespace {

/// A piece of the block at (x, 0, 0) with `triangles` times the same triangle.
std::unique_ptr<SurfacePiece> piece_at(int x, std::size_t triangles) {
    auto piece = std::make_unique<SurfacePiece>();
    piece->at = {x, 0, 0};
    piece->corner_W = {0.32F * static_cast<float>(x), 0.0F, 0.0F};
    for (const float side : {0.0F, 0.1F, 0.2F}) {
        piece->vertices.push_back({.p_W = piece->corner_W + Eigen::Vector3f(side, -0.01F, side * side),
                                   .normal_W = -Eigen::Vector3f::UnitZ(),
                                   .grey = 200.4F});
    }
    for (std::size_t i = 0; i < triangles; ++i) {
        piece->triangles.push_back({.vertex = {0, 1, 2}});
    }
    return piece;
}

std::int32_t integer(const std::string& body, std::size_t at, std::size_t bytes) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i) {
        value |= static_cast<std::uint32_t>(static_cast<unsigned char>(body.at(at + i))) << (8 * i);
    }
    const std::size_t shift = 32 - 8 * bytes;
    return static_cast<std::int32_t>(value << shift) >> shift;
}

constexpr std::size_t kOneTriangle = 56;  // bytes: 20 and three times 10 and 6, filled up

TEST_CASE("a piece is sent with its places to a tenth of a millimetre") {
    LiveSurface surface;
    surface.take(*piece_at(-2, 1), 0);
    LiveSurface::Position position;
    std::string body;
    REQUIRE(surface.append_changes(position, 1, body));
    REQUIRE(body.size() == kOneTriangle);
    CHECK(integer(body, 0, 4) == -6400);
    CHECK(integer(body, 4, 4) == 0);
    CHECK(integer(body, 12, 4) == 3);
    CHECK(integer(body, 16, 4) == 1);
    const std::size_t second = 30;
    CHECK(integer(body, second, 2) == 1000);
    CHECK(integer(body, second + 2, 2) == -100);
    CHECK(integer(body, second + 4, 2) == 100);
    CHECK(integer(body, second + 6, 1) == 0);
    CHECK(integer(body, second + 8, 1) == -127);
    CHECK(integer(body, second + 9, 1) == integer("\xc8", 0, 1));
    CHECK(integer(body, 50, 2) == 0);
    CHECK(integer(body, 54, 2) == 2);
}

TEST_CASE("each browser is sent what has changed since it was sent anything, the oldest first and in parts") {
    LiveSurface surface;
    for (int x = 0; x < 5; ++x) {
        surface.take(*piece_at(x, 1), 0);
    }
    LiveSurface::Position position;
    std::string first;
    REQUIRE(surface.append_changes(position, 2 * kOneTriangle, first));
    CHECK(first.size() == 2 * kOneTriangle);
    surface.take(*piece_at(1, 1), 0);  // again
    std::string rest;
    REQUIRE(surface.append_changes(position, 1000, rest));
    std::vector<int> corners;
    for (std::size_t at = 0; at < rest.size(); at += kOneTriangle) {
        corners.push_back(integer(rest, at, 4) / 3200);
    }
    CHECK(corners == std::vector<int>{2, 3, 4, 1});
    std::string nothing;
    CHECK_FALSE(surface.append_changes(position, 1000, nothing));
    CHECK(nothing.empty());
    LiveSurface::Position late;
    std::string all;
    REQUIRE(surface.append_changes(late, 1000, all));
    CHECK(all.size() == 5 * kOneTriangle);
}

TEST_CASE("a block whose surface is gone is sent without triangles, one that never had any not at all") {
    LiveSurface surface;
    surface.take(*piece_at(0, 0), 0);
    LiveSurface::Position position;
    std::string body;
    CHECK_FALSE(surface.append_changes(position, 1000, body));
    surface.take(*piece_at(0, 1), 0);
    REQUIRE(surface.append_changes(position, 1000, body));
    surface.take(*piece_at(0, 0), 0);
    body.clear();
    REQUIRE(surface.append_changes(position, 1000, body));
    CHECK(integer(body, 16, 4) == 0);
}

TEST_CASE("after a restart there is another surface, which a browser learns even while it is empty") {
    LiveSurface surface;
    surface.take(*piece_at(0, 1), 0);
    LiveSurface::Position position;
    std::string body;
    REQUIRE(surface.append_changes(position, 1000, body));
    const std::uint32_t before = position.surface;
    surface.take(*piece_at(7, 0), 1);
    body.clear();
    REQUIRE(surface.append_changes(position, 1000, body));
    CHECK(body.empty());
    CHECK(position.surface != before);
    CHECK_FALSE(surface.append_changes(position, 1000, body));
    surface.take(*piece_at(7, 1), 1);
    REQUIRE(surface.append_changes(position, 1000, body));
    CHECK(body.size() == kOneTriangle);
}

TEST_CASE("memory is bounded: new blocks are left out when it is full, known ones still change") {
    LiveSurface surface;
    constexpr std::size_t kMany = 3000;  // triangles: 18 KB
    const int room = static_cast<int>(LiveSurface::kMaxBytes / (6 * kMany));
    for (int x = 0; x < room + 10; ++x) {
        surface.take(*piece_at(x, kMany), 0);
    }
    CHECK(surface.dropped() >= 10);
    const std::uint64_t before = surface.dropped();
    surface.take(*piece_at(0, 1), 0);
    CHECK(surface.dropped() == before);
}

}  // namespace
}  // namespace facet::live_surface_test
