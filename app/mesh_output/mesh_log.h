// SPDX-License-Identifier: BSD-2-Clause
// mesh.csv: what the mesher did at each keyframe.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "app/support/text_file.h"
#include "mesh/mesher.h"

namespace facet {

/// One counter of the mesher, by name: for mesh.csv and summary.json.
struct MeshColumn {
    std::string name;
    std::uint64_t value;
};
std::vector<MeshColumn> mesh_columns(const MeshCounters& counters);

/// A row a keyframe: stamp_ns, vertices, faces, and how much each of MeshCounters grew. Throws InputError if it cannot be
/// written. Thread-bound.
class MeshLog {
public:
    explicit MeshLog(const std::string& folder);
    void write(Timestamp stamp, const Mesher& mesher);
    void close() { file_.close(); }

private:
    TextFile file_;
    MeshCounters last_;
};

}  // namespace facet
