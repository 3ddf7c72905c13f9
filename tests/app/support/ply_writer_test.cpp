// SPDX-License-Identifier: BSD-2-Clause
// Binary PLY: header, byte order, counts, refusals.
#include "app/support/ply_writer.h"

#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "app/support/ply_reader.h"

namespace facet::ply_writer_test {
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

TEST_CASE("A mesh with all attributes is read back") {
    const std::string path = temporary_path();
    PlyMesh mesh;
    mesh.vertices = kVertices;
    mesh.triangles = kTriangles;
    const std::array<Eigen::Vector3f, 3> normals{Eigen::Vector3f::UnitX(), Eigen::Vector3f::UnitY(),
                                                 Eigen::Vector3f::UnitZ()};
    const std::array<std::int32_t, 1> one{-1};
    const std::array<float, 1> sigma{0.5F};
    mesh.normals = normals;
    mesh.planes = one;
    mesh.observations = one;
    mesh.sigmas = sigma;
    REQUIRE(ok(write_ply(path, "", mesh)));
    PlyTriangles read;
    std::string error;
    REQUIRE(ok(read_ply(path, read, error)));
    REQUIRE(read.vertices.size() == 3);
    CHECK(read.vertices[2] == kVertices[2].cast<double>());
    REQUIRE(read.triangles.size() == 1);
    CHECK(read.triangles[0] == kTriangles[0]);
    std::filesystem::resize_file(path, std::filesystem::file_size(path) - 1);
    CHECK(read_ply(path, read, error) == Status::kCorrupt);
    CHECK(error == path + ": truncated");
    CHECK(read.triangles.size() == 1);  // untouched
    std::filesystem::remove(path);
    CHECK(read_ply(path, read, error) == Status::kIo);
    mesh.planes = {};
    mesh.normals = std::span(normals).first(2);
    CHECK(write_ply(path, "", mesh) == Status::kInvalidArgument);
}

TEST_CASE("ASCII polygons are read as fans, and what is no mesh is refused") {
    const std::string path = temporary_path();
    const auto read_text = [&](const std::string& text, PlyTriangles& mesh) {
        std::ofstream(path) << text;
        std::string error;
        return read_ply(path, mesh, error);
    };
    const std::string head =
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n"
        "element face 1\nproperty list uchar int vertex_index\nend_header\n";
    const std::string points = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
    PlyTriangles mesh;
    REQUIRE(ok(read_text(head + points + "4 0 1 2 3\n", mesh)));
    REQUIRE(mesh.triangles.size() == 2);
    CHECK(mesh.triangles[0] == Eigen::Vector3i(0, 1, 2));
    CHECK(mesh.triangles[1] == Eigen::Vector3i(0, 2, 3));
    CHECK(read_text(head + points + "4 0 1 2 4\n", mesh) == Status::kCorrupt);
    CHECK(read_text(head + points, mesh) == Status::kCorrupt);
    CHECK(read_text("solid\n", mesh) == Status::kCorrupt);
    // Lengths below zero, or of nothing, would be read for ever.
    const std::string format = "ply\nformat ascii 1.0\n";
    CHECK(read_text(format + "element vertex -1\nproperty float x\nend_header\n", mesh) == Status::kCorrupt);
    CHECK(ok(read_text(format + "element thing 99999999999999\nend_header\n", mesh)));
    CHECK(read_text(format + "element face 1\nproperty list int int vertex_index\nend_header\n-5 1 2 3\n", mesh) ==
          Status::kCorrupt);
    CHECK(read_text(head + points + "3 0 1 1e300\n", mesh) == Status::kCorrupt);
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
}  // namespace facet::ply_writer_test
