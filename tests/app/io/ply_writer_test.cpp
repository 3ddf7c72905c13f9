// SPDX-License-Identifier: BSD-2-Clause
// Binary PLY: header, byte order, counts, refusals.
#include "app/io/ply_writer.h"

#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace facet {
namespace {

std::string temporary_path() {
    return (std::filesystem::temp_directory_path() / ("facet_ply_" + std::to_string(::getpid()) + ".ply")).string();
}

std::string read_all(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

const std::array<Eigen::Vector3f, 3> kVertices{Eigen::Vector3f(1.0F, -2.0F, 0.5F), Eigen::Vector3f(0.0F, 0.0F, 0.0F),
                                               Eigen::Vector3f(3.0F, 4.0F, 5.0F)};
const std::array<Eigen::Vector3i, 1> kTriangles{Eigen::Vector3i(0, 2, 1)};

TEST_CASE("A mesh is written as little-endian PLY") {
    const std::string path = temporary_path();
    REQUIRE(ok(write_ply(path, "a comment", kVertices, kTriangles)));
    const std::string text = read_all(path);
    const std::string end = "end_header\n";
    const std::size_t body = text.find(end) + end.size();
    CHECK(text.rfind("ply\nformat binary_little_endian 1.0\ncomment a comment\nelement vertex 3\n", 0) == 0);
    CHECK(text.find("element face 1\n") != std::string::npos);
    REQUIRE(text.size() == body + 3 * 12 + 13);
    const unsigned char minus_two[4] = {0x00, 0x00, 0x00, 0xc0};  // -2.0f, least significant byte first
    CHECK(std::memcmp(text.data() + body + 4, minus_two, 4) == 0);
    const unsigned char face[13] = {3, 0, 0, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0};
    CHECK(std::memcmp(text.data() + body + 36, face, 13) == 0);
    std::filesystem::remove(path);
}

TEST_CASE("Colours follow each vertex") {
    const std::string path = temporary_path();
    using Colour = Eigen::Matrix<std::uint8_t, 3, 1>;
    const std::array<Colour, 3> colours{Colour(1, 2, 3), Colour(4, 5, 6), Colour(250, 251, 252)};
    REQUIRE(ok(write_ply(path, "", kVertices, kTriangles, colours)));
    const std::string text = read_all(path);
    const std::size_t body = text.find("end_header\n") + 11;
    REQUIRE(text.size() == body + 3 * 15 + 13);
    CHECK(static_cast<unsigned char>(text[body + 2 * 15 + 12]) == 250);
    std::filesystem::remove(path);
}

TEST_CASE("Contradictions and unwritable paths are refused") {
    const std::string path = temporary_path();
    const std::array<Eigen::Vector3i, 1> out_of_range{Eigen::Vector3i(0, 1, 3)};
    CHECK(write_ply(path, "", kVertices, out_of_range) == Status::kInvalidArgument);
    CHECK(write_ply(path, "two\nlines", kVertices, kTriangles) == Status::kInvalidArgument);
    CHECK_FALSE(std::filesystem::exists(path));
    CHECK(write_ply("/nonexistent_folder/x.ply", "", kVertices, kTriangles) == Status::kIo);
}

}  // namespace
}  // namespace facet
