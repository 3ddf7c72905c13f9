// SPDX-License-Identifier: BSD-2-Clause
#include "app/io/ply_writer.h"

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

}  // namespace

Status write_ply(const std::string& path, const std::string& comment, std::span<const Eigen::Vector3f> vertices,
                 std::span<const Eigen::Vector3i> triangles,
                 std::span<const Eigen::Matrix<std::uint8_t, 3, 1>> colours) {
    const auto count = static_cast<int>(vertices.size());
    const bool indices_ok = std::all_of(triangles.begin(), triangles.end(), [count](const Eigen::Vector3i& t) {
        return t.minCoeff() >= 0 && t.maxCoeff() < count;
    });
    if (!indices_ok || (!colours.empty() && colours.size() != vertices.size()) ||
        comment.find('\n') != std::string::npos) {
        return Status::kInvalidArgument;
    }
    std::ofstream file(path, std::ios::binary);
    file << "ply\nformat binary_little_endian 1.0\n";
    if (!comment.empty()) {
        file << "comment " << comment << '\n';
    }
    file << "element vertex " << vertices.size() << "\nproperty float x\nproperty float y\nproperty float z\n";
    if (!colours.empty()) {
        file << "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    }
    file << "element face " << triangles.size() << "\nproperty list uchar int vertex_indices\nend_header\n";

    std::vector<char> body;
    body.reserve(vertices.size() * 15 + triangles.size() * 13);
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        for (int k = 0; k < 3; ++k) {
            put_word(body, std::bit_cast<std::uint32_t>(vertices[i][k]));
        }
        for (int k = 0; k < 3 && !colours.empty(); ++k) {
            body.push_back(static_cast<char>(colours[i][k]));
        }
    }
    for (const Eigen::Vector3i& t : triangles) {
        body.push_back(3);
        for (int k = 0; k < 3; ++k) {
            put_word(body, static_cast<std::uint32_t>(t[k]));
        }
    }
    file.write(body.data(), static_cast<std::streamsize>(body.size()));
    file.close();
    return file ? Status::kOk : Status::kIo;
}

}  // namespace facet
