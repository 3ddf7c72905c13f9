// SPDX-License-Identifier: BSD-2-Clause
// mesh.csv: what the mesher did at each keyframe.
#pragma once

#include <string>
#include <vector>

#include "app/support/named_counter.h"
#include "app/support/text_file.h"
#include "mesh/mesher.h"

namespace facet {

/// The mesher's counters, for mesh.csv and summary.json.
std::vector<NamedCounter> named_counters(const MeshCounters& counters);

/// A row for every keyframe: stamp_ns, vertices, faces, and the increase of each of MeshCounters. Throws InputError if
/// it cannot be written. Thread-bound.
class MeshLog {
public:
    explicit MeshLog(const std::string& folder);
    void write(Timestamp stamp, int vertices, int faces, const MeshCounters& counters);
    void flush() { file_.flush(); }
    void close() { file_.close(); }

private:
    TextFile file_;
    MeshCounters last_;
};

}  // namespace facet
