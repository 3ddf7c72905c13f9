// SPDX-License-Identifier: BSD-2-Clause
#include "app/output/plane_log.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/output/plane_regions.h"
#include "app/output/ply_file.h"

namespace facet {
namespace {

using Json = nlohmann::ordered_json;
using Colour = Eigen::Matrix<std::uint8_t, 3, 1>;

/// A plane found more often than this and then given up has been one: its landmarks end badly as it leaves the view.
constexpr int kFewKeyframes = 8;

Json array(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// Points to the millimetre.
Json array(const PlaneRing& ring) {
    const auto rounded = [](double m) { return std::round(1e3 * m) / 1e3; };
    Json points = Json::array();
    for (const Eigen::Vector2d& p : ring) {
        points.push_back({rounded(p.x()), rounded(p.y())});
    }
    return points;
}

Json describe(const PlaneRegion& region) {
    Json holes = Json::array();
    for (const PlaneRing& hole : region.holes) {
        holes.push_back(array(hole));
    }
    return {{"area", region.area_m2}, {"boundary", array(region.boundary)}, {"holes", holes}};
}

std::vector<PlaneTriangle> triangles_on(const PlaneAxes& axes, const std::vector<const DepartedFace*>& faces) {
    std::vector<PlaneTriangle> triangles;
    for (const DepartedFace* face : faces) {
        PlaneTriangle& triangle = triangles.emplace_back();
        for (std::size_t k = 0; k < 3; ++k) {
            triangle[k] = axes.to_plane(face->p_W[k].cast<double>());
        }
    }
    return triangles;
}

/// Of the ellipsoid of what is not known: place and both turns.
double volume(const PlaneFit& fit) { return fit.sigma_m * fit.sigma_along_rad * fit.sigma_across_rad; }

/// Neighbouring ids are far apart on the colour circle.
Colour colour_of(std::uint32_t id) {
    constexpr double kGoldenTurn = 0.61803398875;
    const double turn = std::fmod(kGoldenTurn * id, 1.0);
    const auto channel = [&](double offset) {
        const double distance = std::abs(std::fmod(turn + offset, 1.0) - 0.5);  // 0.5 at the channel's own hue
        return static_cast<std::uint8_t>(60.0 + 180.0 * std::clamp(6.0 * distance - 1.0, 0.0, 1.0));
    };
    return {channel(0.0), channel(2.0 / 3.0), channel(1.0 / 3.0)};
}

/// The regions of all planes as triangles.
class SurfacePicture {
public:
    void add(std::uint32_t id, const PlaneAxes& axes, const PlaneRegion& region) {
        for (const PlaneTriangle& triangle : triangulate(region)) {
            const auto first = static_cast<int>(vertices_.size());
            for (const Eigen::Vector2d& p : triangle) {
                vertices_.push_back(axes.to_world(p).cast<float>());
                normals_.push_back(axes.R_W_A.col(2).cast<float>());
                colours_.push_back(colour_of(id));
            }
            triangles_.emplace_back(first, first + 1, first + 2);
            planes_.push_back(static_cast<std::int32_t>(id));
        }
    }

    void write(const std::string& path) const {
        PlyMesh mesh;
        mesh.vertices = vertices_;
        mesh.normals = normals_;
        mesh.colours = colours_;
        mesh.triangles = triangles_;
        mesh.planes = planes_;
        replace_ply(path, "facet: planes, world frame of the estimate, metres", mesh);
    }

private:
    std::vector<Eigen::Vector3f> vertices_;
    std::vector<Eigen::Vector3f> normals_;
    std::vector<Colour> colours_;
    std::vector<Eigen::Vector3i> triangles_;
    std::vector<std::int32_t> planes_;
};

}  // namespace

std::vector<NamedCounter> named_counters(const PlaneCounters& c) {
    return {{"candidates", c.candidates},   {"refused", c.refused},     {"confirmed", c.confirmed},
            {"found_again", c.found_again}, {"recalled", c.recalled},   {"merged", c.merged},
            {"doubted", c.doubted},         {"forgotten", c.forgotten}, {"crowded_out", c.crowded_out}};
}

PlaneLog::PlaneLog(const std::string& folder) : file_(folder + "/planes.csv") {
    file_.write(
        "stamp_ns,id,kind,nx,ny,nz,distance_m,landmarks,area_m2,is_held,lost,doubts,sigma_m,sigma_along_rad,"
        "sigma_across_rad,chi2,bend_m,cx,cy,cz,extent_along_m,extent_across_m\n");
}

/// One record of two, the plane as it was known best in either.
void PlaneLog::unite(const PlaneMerge& merge) {
    names_.learn(merge);
    const auto gone = records_.find(merge.gone.value);
    if (gone == records_.end()) {
        return;
    }
    const Record& other = gone->second;
    Record& own = records_.try_emplace(merge.stays.value, other).first->second;
    own.first = std::min(own.first, other.first);
    if (other.last > own.last) {
        own.last = other.last;
        own.is_doubted = other.is_doubted;
    }
    own.found = std::max(own.found, other.found);
    if (volume(other.plane.fit) < volume(own.plane.fit)) {
        own.plane = other.plane;
    }
    own.plane.id = merge.stays;
    records_.erase(gone);
}

void PlaneLog::write(Timestamp stamp, std::span<const TrackedPlane> planes, std::span<const PlaneFit> claims,
                     std::span<const PlaneMerge> merges) {
    newest_ = stamp;
    for (const PlaneMerge& merge : merges) {
        unite(merge);
    }
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
        TrackedPlane claimed = *plane;
        claimed.fit = claims[static_cast<std::size_t>(plane - planes.data())];
        const auto at = records_.try_emplace(plane->id.value, Record{claimed, stamp, stamp}).first;
        at->second.last = stamp;
        at->second.found = plane->found;
        at->second.is_doubted = plane->doubts > 0;
        if (plane->lost == 0 && volume(claimed.fit) <= volume(at->second.plane.fit)) {
            at->second.plane = claimed;
        }
    }
}

/// Doubted once, and no longer told at the next keyframe: doubted again.
bool PlaneLog::is_taken_back(const Record& record) const {
    return record.is_doubted && record.last < newest_ && record.found <= kFewKeyframes;
}

/// planes.json in the format of mesh/README.md, a plane a line.
void PlaneLog::write_planes(const std::string& folder, std::span<const DepartedFace> faces) const {
    std::map<std::uint32_t, std::vector<const DepartedFace*>> faces_of;
    for (const DepartedFace& face : faces) {
        if (face.plane.valid()) {
            faces_of[names_.now(face.plane).value].push_back(&face);
        }
    }
    SurfacePicture picture;
    std::string text = "[";
    for (const auto& [id, record] : records_) {
        if (is_taken_back(record)) {
            continue;
        }
        const PlaneFit& fit = record.plane.fit;
        const PlaneAxes axes(fit, record.plane.kind);
        const std::vector<PlaneRegion> regions = find_plane_regions(triangles_on(axes, faces_of[id]));
        Json plane = {{"id", id},
                      {"normal", array(fit.normal_W)},
                      {"distance", fit.distance_m},
                      {"inliers", record.plane.landmarks},
                      {"kind", to_string(record.plane.kind)},
                      {"centroid", array(fit.centroid_W)},
                      {"extent", {fit.extent_along_m, fit.extent_across_m}},
                      {"area", record.plane.area_m2},
                      {"first_stamp_ns", record.first.ns},
                      {"last_stamp_ns", record.last.ns},
                      {"sigma", fit.sigma_m},
                      {"sigma_turn", {axes.sigma_turn.x(), axes.sigma_turn.y()}},
                      {"origin", array(axes.origin_W)},
                      {"axes", {array(axes.R_W_A.col(0)), array(axes.R_W_A.col(1))}},
                      {"regions", Json::array()}};
        for (const PlaneRegion& region : regions) {
            plane["regions"].push_back(describe(region));
            picture.add(id, axes, region);
        }
        text += (text.size() > 1 ? ",\n " : "\n ") + plane.dump();
    }
    TextFile file(folder + "/planes.json");
    file.write(text + "\n]\n");
    file.close();
    picture.write(folder + "/planes.ply");
}

}  // namespace facet
