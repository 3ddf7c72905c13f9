// SPDX-License-Identifier: BSD-2-Clause
#include "app/output/plane_log.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace facet {

std::vector<NamedCounter> named_counters(const PlaneCounters& c) {
    return {{"candidates", c.candidates},   {"refused", c.refused},        {"confirmed", c.confirmed},
            {"found_again", c.found_again}, {"merged", c.merged},          {"doubted", c.doubted},
            {"forgotten", c.forgotten},     {"crowded_out", c.crowded_out}};
}

PlaneLog::PlaneLog(const std::string& folder) : file_(folder + "/planes.csv") {
    file_.write(
        "stamp_ns,id,kind,nx,ny,nz,distance_m,landmarks,area_m2,is_held,lost,doubts,sigma_m,sigma_along_rad,"
        "sigma_across_rad,chi2,bend_m,cx,cy,cz,extent_along_m,extent_across_m\n");
}

void PlaneLog::write(Timestamp stamp, std::span<const TrackedPlane> planes) {
    std::vector<const TrackedPlane*>& reported = reported_;  // storage kept from keyframe to keyframe
    reported.clear();
    for (const TrackedPlane& plane : planes) {
        if (plane.is_reported) {
            reported.push_back(&plane);
        }
    }
    std::sort(reported.begin(), reported.end(),
              [](const TrackedPlane* a, const TrackedPlane* b) { return a->id.value < b->id.value; });
    for (const TrackedPlane* plane : reported) {
        const PlaneFit& f = plane->fit;
        file_.print("{},{},{},{:.8f},{:.8f},{:.8f},{:.6f},{},{:.4f},{:d},{},{}", stamp.ns, plane->id.value,
                    to_string(plane->kind), f.normal_W.x(), f.normal_W.y(), f.normal_W.z(), f.distance_m,
                    plane->landmarks, plane->area_m2, plane->is_held, plane->lost, plane->doubts);
        file_.print(",{:.5f},{:.6f},{:.6f},{:.4f},{:.5f},{:.4f},{:.4f},{:.4f},{:.3f},{:.3f}\n", f.sigma_m,
                    f.sigma_along_rad, f.sigma_across_rad, f.chi2, f.bend_m, f.centroid_W.x(), f.centroid_W.y(),
                    f.centroid_W.z(), f.extent_along_m, f.extent_across_m);
        const auto at = records_.try_emplace(plane->id.value, Record{*plane, stamp, stamp}).first;
        at->second.last = stamp;
        if (plane->lost == 0) {
            at->second.plane = *plane;
        }
    }
}

/// The format of mesh/README.md.
void PlaneLog::write_planes(const std::string& folder) const {
    const auto array = [](const Eigen::Vector3d& v) { return nlohmann::ordered_json{v.x(), v.y(), v.z()}; };
    nlohmann::ordered_json planes = nlohmann::ordered_json::array();
    for (const auto& [id, record] : records_) {
        const PlaneFit& fit = record.plane.fit;
        planes.push_back({{"id", id},
                          {"normal", array(fit.normal_W)},
                          {"distance", fit.distance_m},
                          {"inliers", record.plane.landmarks},
                          {"kind", to_string(record.plane.kind)},
                          {"centroid", array(fit.centroid_W)},
                          {"extent", {fit.extent_along_m, fit.extent_across_m}},
                          {"area", record.plane.area_m2},
                          {"first_stamp_ns", record.first.ns},
                          {"last_stamp_ns", record.last.ns}});
    }
    TextFile file(folder + "/planes.json");
    file.write(planes.dump(2) + "\n");
    file.close();
}

}  // namespace facet
