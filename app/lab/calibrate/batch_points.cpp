// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/calibrate/batch_points.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <map>

namespace facet {
namespace {

constexpr std::size_t kMinKeyframes = 3;
constexpr double kMinParallaxRad = 3e-3;  // rms angle between the lines of sight: some ten times their error
constexpr double kMaxErrorPx = 8.0;       // a wrong calibration explains a few pixels
constexpr double kMinDepthM = 0.1;

/// A line of sight with what it came from.
struct SightLine {
    BatchSighting sighting;
    Eigen::Vector3d centre_W;
    Eigen::Vector3d direction_W;
    Se3 T_C_W;
};

/// Adds the line of one image. Left out if the pixel has no bearing.
void add_line(const RecordedKeyframe& keyframe, int index, int camera, const Eigen::Vector2d& px, const RigAndTime& rig,
              std::vector<SightLine>& lines) {
    const CameraModel& model = camera == 0 ? rig.rig.left : rig.rig.right;
    Eigen::Vector2d xy;
    if (!ok(model.unproject(px, xy))) {
        return;
    }
    const Se3 T_W_C = keyframe.state.T_W_B() * (camera == 0 ? rig.rig.T_B_C0 : rig.rig.T_B_C1);
    lines.push_back({.sighting = {.keyframe = index, .camera = camera, .px = px},
                     .centre_W = T_W_C.p,
                     .direction_W = (T_W_C.q * xy.homogeneous()).normalized(),
                     .T_C_W = T_W_C.inverse()});
}

bool fits(const SightLine& line, const Eigen::Vector3d& p_W, const RigAndTime& rig) {
    const Eigen::Vector3d p_C = line.T_C_W * p_W;
    Eigen::Vector2d uv;
    const CameraModel& model = line.sighting.camera == 0 ? rig.rig.left : rig.rig.right;
    return p_C.z() > kMinDepthM && ok(model.project(p_C, uv)) && (uv - line.sighting.px).norm() < kMaxErrorPx;
}

/// @return whether the lines meet in a usable point
bool meet(const std::vector<SightLine>& lines, const RigAndTime& rig, Eigen::Vector3d& p_W) {
    Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    for (const SightLine& line : lines) {
        const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - line.direction_W * line.direction_W.transpose();
        a += across;
        b += across * line.centre_W;
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(a);
    const double parallax2 = eigen.eigenvalues()(0) / static_cast<double>(lines.size());
    if (parallax2 < kMinParallaxRad * kMinParallaxRad) {
        return false;
    }
    p_W = a.ldlt().solve(b);
    return std::ranges::all_of(lines, [&](const SightLine& line) { return fits(line, p_W, rig); });
}

}  // namespace

BatchPoints triangulate_points(const RecordedFlight& flight, const RigAndTime& rig) {
    std::map<std::uint32_t, std::vector<SightLine>> lines_of;
    std::map<std::uint32_t, std::size_t> keyframes_of;
    for (std::size_t k = 0; k < flight.keyframes.size(); ++k) {
        for (const PointSighting& s : flight.keyframes[k].sightings) {
            std::vector<SightLine>& lines = lines_of[s.point];
            const int index = static_cast<int>(k);
            add_line(flight.keyframes[k], index, 0, s.left_px, rig, lines);
            if (s.has_right) {
                add_line(flight.keyframes[k], index, 1, s.right_px, rig, lines);
            }
            ++keyframes_of[s.point];
        }
    }
    struct Candidate {
        Eigen::Vector3d p_W;
        const std::vector<SightLine>* lines;
    };
    std::vector<Candidate> candidates;
    for (const auto& [point, lines] : lines_of) {
        Eigen::Vector3d p_W;
        if (keyframes_of[point] >= kMinKeyframes && meet(lines, rig, p_W)) {
            candidates.push_back({p_W, &lines});
        }
    }
    std::ranges::stable_sort(candidates, std::greater{}, [](const Candidate& c) { return c.lines->size(); });
    candidates.resize(std::min(candidates.size(), kMaxBatchPoints));
    BatchPoints points;
    for (const Candidate& candidate : candidates) {
        for (const SightLine& line : *candidate.lines) {
            points.sightings.push_back(line.sighting);
            points.sightings.back().point = static_cast<int>(points.p_W.size());
        }
        points.p_W.push_back(candidate.p_W);
    }
    return points;
}

}  // namespace facet
