// SPDX-License-Identifier: BSD-2-Clause
#include "app/support/ply_reader.h"
#include "tests/fuzz/fuzz_input.h"

using namespace facet;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const test::MemoryFile file({data, size});
    PlyTriangles mesh;
    std::string error;
    if (!ok(read_ply(file.path(), mesh, error))) {
        test::require(!error.empty() && error.find('\n') == std::string::npos);
        return 0;
    }
    const auto count = static_cast<int>(mesh.vertices.size());
    for (const Eigen::Vector3d& vertex : mesh.vertices) {
        test::require(vertex.allFinite());
    }
    for (const Eigen::Vector3i& triangle : mesh.triangles) {
        test::require(triangle.minCoeff() >= 0 && triangle.maxCoeff() < count);
    }
    return 0;
}
