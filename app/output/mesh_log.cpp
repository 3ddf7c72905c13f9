// SPDX-License-Identifier: BSD-2-Clause
#include "app/output/mesh_log.h"

#include <array>

namespace facet {
namespace {

/// A counter that is not of a verdict, and its name.
struct Column {
    const char* name;
    std::uint64_t MeshCounters::*count;
};

constexpr std::array kColumns{
    Column{"duplicate_points", &MeshCounters::duplicate_points},
    Column{"added", &MeshCounters::added},
    Column{"confirmed", &MeshCounters::confirmed},
    Column{"superseded", &MeshCounters::superseded},
    Column{"contradicted", &MeshCounters::contradicted},
    Column{"misshapen", &MeshCounters::misshapen},
    Column{"judged_bad", &MeshCounters::judged_bad},
    Column{"departed", &MeshCounters::departed},
    Column{"doubtful", &MeshCounters::doubtful},
    Column{"dropped", &MeshCounters::dropped},
    Column{"refused", &MeshCounters::refused},
    Column{"aged", &MeshCounters::aged},
    Column{"flown_through", &MeshCounters::flown_through},
    Column{"turned", &MeshCounters::turned},
    Column{"rehosted", &MeshCounters::rehosted},
    Column{"holes_filled", &MeshCounters::holes_filled},
    Column{"fill_faces", &MeshCounters::fill_faces},
};

}  // namespace

std::vector<NamedCounter> named_counters(const MeshCounters& c) {
    std::vector<NamedCounter> counters;
    for (std::size_t i = 0; i < c.verdicts.size(); ++i) {
        counters.push_back({std::string("triangles_") + to_string(static_cast<FaceVerdict>(i)), c.verdicts[i]});
    }
    for (const Column& column : kColumns) {
        counters.push_back({column.name, c.*column.count});
    }
    return counters;
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
    for (std::size_t i = 0; i < counters.verdicts.size(); ++i) {
        file_.print(",{}", counters.verdicts[i] - last_.verdicts[i]);
    }
    for (const Column& column : kColumns) {
        file_.print(",{}", counters.*column.count - last_.*column.count);
    }
    file_.write("\n");
    last_ = counters;
}

}  // namespace facet
