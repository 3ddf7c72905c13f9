// SPDX-License-Identifier: BSD-2-Clause
#include "app/pipeline/scene_description.h"

#include <algorithm>
#include <cmath>

namespace facet {
namespace {

std::int32_t number_of(PlaneId plane) { return plane.valid() ? static_cast<std::int32_t>(plane.value) : -1; }

/// Of points spread evenly over a rectangle: half its side over their standard deviation.
const double kHalfSide = std::sqrt(3.0);

}  // namespace

void append_faces(const Mesher& mesher, std::vector<SceneFace>& faces) {
    const HorizonMesh& mesh = mesher.mesh();
    for (int i = 0; i < mesh.face_end(); ++i) {
        if (mesh.is_face(i)) {
            const DepartedFace face = mesher.describe(mesh.face(static_cast<FaceIndex>(i)));
            faces.push_back({face.p_W, number_of(face.plane)});
        }
    }
}

ScenePlane to_scene(const TrackedPlane& plane) {
    const PlaneFit& fit = plane.fit;
    return {.id = number_of(plane.id),
            .kind = plane.kind,
            .centre_W = fit.centroid_W.cast<float>(),
            .along_W = (kHalfSide * fit.extent_along_m * fit.along_W).cast<float>(),
            .across_W = (kHalfSide * fit.extent_across_m * fit.across_W).cast<float>()};
}

MessageTimes to_message_times(const FrameTiming& timing) {
    static_assert(kMessageTimes == 2 + kStageCount);
    const auto to_time = [](const SpentTime& spent) { return MessageTime{spent.wall_ms, spent.processor_ms}; };
    MessageTimes times{to_time(timing.total), to_time(timing.estimate)};
    std::ranges::transform(timing.stages, times.begin() + 2, to_time);
    return times;
}

}  // namespace facet
