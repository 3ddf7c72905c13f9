// SPDX-License-Identifier: BSD-2-Clause
#include "app/output/mesh_log.h"

namespace facet {

std::vector<NamedCounter> named_counters(const MeshCounters& c) {
    std::vector<NamedCounter> columns;
    for (std::size_t i = 0; i < c.verdicts.size(); ++i) {
        columns.push_back({std::string("triangles_") + to_string(static_cast<FaceVerdict>(i)), c.verdicts[i]});
    }
    columns.insert(columns.end(), {{"duplicate_points", c.duplicate_points},
                                   {"added", c.added},
                                   {"confirmed", c.confirmed},
                                   {"superseded", c.superseded},
                                   {"contradicted", c.contradicted},
                                   {"misshapen", c.misshapen},
                                   {"judged_bad", c.judged_bad},
                                   {"departed", c.departed},
                                   {"doubtful", c.doubtful},
                                   {"dropped", c.dropped},
                                   {"refused", c.refused},
                                   {"aged", c.aged},
                                   {"flown_through", c.flown_through},
                                   {"turned", c.turned},
                                   {"rehosted", c.rehosted},
                                   {"holes_filled", c.holes_filled},
                                   {"fill_faces", c.fill_faces}});
    return columns;
}

MeshLog::MeshLog(const std::string& folder) : file_(folder + "/mesh.csv") {
    file_.write("stamp_ns,vertices,faces");
    for (const NamedCounter& counter : named_counters(MeshCounters{})) {
        file_.print(",{}", counter.name);
    }
    file_.write("\n");
}

void MeshLog::write(Timestamp stamp, int vertices, int faces, const MeshCounters& counters) {
    file_.print("{},{},{}", stamp.ns, vertices, faces);
    const std::vector<NamedCounter> before = named_counters(last_);
    const std::vector<NamedCounter> now = named_counters(counters);
    for (std::size_t i = 0; i < now.size(); ++i) {
        file_.print(",{}", now[i].value - before[i].value);
    }
    file_.write("\n");
    last_ = counters;
}

}  // namespace facet
