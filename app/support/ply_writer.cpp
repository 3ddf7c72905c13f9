// SPDX-License-Identifier: BSD-2-Clause
#include "app/support/ply_writer.h"

#include <algorithm>
#include <bit>
#include <fstream>
#include <vector>

namespace facet {
namespace {

void put_word(std::vector<char>& out, std::uint32_t word) {
    for (int shift = 0; shift < 32; shift += 8) {
        out.push_back(static_cast<char>((word >> shift) & 0xffU));
    }
}

void put_vector(std::vector<char>& out, const Eigen::Vector3f& v) {
    for (int k = 0; k < 3; ++k) {
        put_word(out, std::bit_cast<std::uint32_t>(v[k]));
    }
}

bool is_consistent(const PlyMesh& mesh) {
    const auto count = static_cast<int>(mesh.vertices.size());
    const auto fits = [](std::size_t attributes, std::size_t elements) {
        return attributes == 0 || attributes == elements;
    };
    return fits(mesh.normals.size(), mesh.vertices.size()) && fits(mesh.colours.size(), mesh.vertices.size()) &&
           fits(mesh.planes.size(), mesh.triangles.size()) && fits(mesh.sigmas.size(), mesh.triangles.size()) &&
           fits(mesh.observations.size(), mesh.triangles.size()) &&
           std::all_of(mesh.triangles.begin(), mesh.triangles.end(),
                       [count](const Eigen::Vector3i& t) { return t.minCoeff() >= 0 && t.maxCoeff() < count; });
}

std::string header(const std::string& comment, const PlyMesh& mesh) {
    std::string text = "ply\nformat binary_little_endian 1.0\n";
    text += comment.empty() ? "" : "comment " + comment + "\n";
    text += "element vertex " + std::to_string(mesh.vertices.size()) +
            "\nproperty float x\nproperty float y\nproperty float z\n";
    text += mesh.normals.empty() ? "" : "property float nx\nproperty float ny\nproperty float nz\n";
    text += mesh.colours.empty() ? "" : "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    text += "element face " + std::to_string(mesh.triangles.size()) + "\nproperty list uchar int vertex_indices\n";
    text += mesh.planes.empty() ? "" : "property int plane_id\n";
    text += mesh.observations.empty() ? "" : "property int observations\n";
    text += mesh.sigmas.empty() ? "" : "property float sigma\n";
    return text + "end_header\n";
}

}  // namespace

Status write_ply(const std::string& path, const std::string& comment, const PlyMesh& mesh) {
    if (!is_consistent(mesh) || comment.find('\n') != std::string::npos) {
        return Status::kInvalidArgument;
    }
    std::vector<char> body;
    body.reserve(mesh.vertices.size() * 27 + mesh.triangles.size() * 25);
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
        put_vector(body, mesh.vertices[i]);
        if (!mesh.normals.empty()) {
            put_vector(body, mesh.normals[i]);
        }
        for (int k = 0; k < 3 && !mesh.colours.empty(); ++k) {
            body.push_back(static_cast<char>(mesh.colours[i][k]));
        }
    }
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        body.push_back(3);
        for (int k = 0; k < 3; ++k) {
            put_word(body, static_cast<std::uint32_t>(mesh.triangles[i][k]));
        }
        if (!mesh.planes.empty()) {
            put_word(body, static_cast<std::uint32_t>(mesh.planes[i]));
        }
        if (!mesh.observations.empty()) {
            put_word(body, static_cast<std::uint32_t>(mesh.observations[i]));
        }
        if (!mesh.sigmas.empty()) {
            put_word(body, std::bit_cast<std::uint32_t>(mesh.sigmas[i]));
        }
    }
    std::ofstream file(path, std::ios::binary);
    file << header(comment, mesh);
    file.write(body.data(), static_cast<std::streamsize>(body.size()));
    file.close();
    return file ? Status::kOk : Status::kIo;
}

Status write_ply(const std::string& path, const std::string& comment, std::span<const Eigen::Vector3f> vertices,
                 std::span<const Eigen::Vector3i> triangles,
                 std::span<const Eigen::Matrix<std::uint8_t, 3, 1>> colours) {
    PlyMesh mesh;
    mesh.vertices = vertices;
    mesh.triangles = triangles;
    mesh.colours = colours;
    return write_ply(path, comment, mesh);
}

}  // namespace facet
