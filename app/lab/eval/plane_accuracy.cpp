// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/plane_accuracy.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "app/support/statistics.h"
#include "platform/base/angle.h"

namespace facet {
namespace {

/// Samples of the true surface on each true plane.
std::vector<std::vector<Eigen::Vector3d>> sample_planes(const SceneTruth& truth, const PlaneEvalOptions& options) {
    std::vector<std::vector<Eigen::Vector3d>> on(truth.planes.size());
    std::vector<int> triangle_of;
    const std::vector<Eigen::Vector3d> samples = sample_surface(truth.surface, options.samples_per_m2, &triangle_of);
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const int plane =
            plane_at(truth.planes, samples[i], truth.surface.normal(static_cast<std::size_t>(triangle_of[i])));
        if (plane >= 0) {
            on[static_cast<std::size_t>(plane)].push_back(samples[i]);
        }
    }
    return on;
}

/// Area of a plane in each view and in all together.
TruePlaneResult look_at(const EvalPlane& plane, const std::vector<Eigen::Vector3d>& samples, const SceneTruth& truth,
                        const TriangleTree& tree, const PlaneEvalOptions& options) {
    TruePlaneResult result;
    result.name = plane.name;
    SceneTruth one{{}, {}, truth.camera, {}};
    std::vector<bool> ever(samples.size(), false);
    for (const Se3& T_W_C0 : truth.T_W_C0) {
        if (plane.normal.dot(T_W_C0.p) < plane.distance) {
            continue;  // seen from behind
        }
        one.T_W_C0 = {T_W_C0};
        int seen = 0;
        for (std::size_t i = 0; i < samples.size(); ++i) {
            if (was_seen(one, tree, samples[i], options.seen_depth_m)) {
                ever[i] = true;
                ++seen;
            }
        }
        const double area = seen / options.samples_per_m2;
        result.area_m2 = std::max(result.area_m2, area);
        result.seen_s += area >= options.seen_area_m2 ? options.pose_interval_s : 0.0;
    }
    result.seen_m2 = static_cast<double>(std::count(ever.begin(), ever.end(), true)) / options.samples_per_m2;
    result.is_wanted =
        result.seen_s >= options.seen_s - 1e-9 && is_level_or_upright(plane.normal, options.max_tilt_deg);
    return result;
}

PlaneMatch match(const PlaneRow& row, const Se3& T_true_est, const SceneTruth& truth,
                 const std::vector<std::vector<Eigen::Vector3d>>& samples, const PlaneEvalOptions& options) {
    const Eigen::Vector3d n = T_true_est.q * row.normal;
    const Eigen::Vector3d c = T_true_est * row.centroid;
    PlaneMatch best;
    for (std::size_t k = 0; k < truth.planes.size(); ++k) {
        const EvalPlane& plane = truth.planes[k];
        const double angle = std::acos(std::clamp(n.dot(plane.normal), -1.0, 1.0)) / kRadPerDeg;
        const double offset = std::abs(plane.normal.dot(c) - plane.distance);
        const auto is_near = [&](const Eigen::Vector3d& p) {
            return (p - c).squaredNorm() < options.match_place_m * options.match_place_m;
        };
        if (angle <= options.match_angle_deg && offset <= options.match_offset_m &&
            (best.truth < 0 || offset < best.offset_m) && std::any_of(samples[k].begin(), samples[k].end(), is_near)) {
            best = {static_cast<int>(k), angle, offset};
        }
    }
    return best;
}

double share_within(const std::vector<double>& values, double limit) {
    const auto within = std::count_if(values.begin(), values.end(), [=](double v) { return v <= limit; });
    return values.empty() ? 0.0 : static_cast<double>(within) / static_cast<double>(values.size());
}

}  // namespace

PlaneEvaluation evaluate_planes(const std::vector<PlaneRow>& rows, const std::optional<PlaneSurfaces>& surfaces,
                                const SceneTruth& truth, const Se3& T_true_est, const PlaneEvalOptions& options) {
    PlaneEvaluation result;
    const std::vector<std::vector<Eigen::Vector3d>> samples = sample_planes(truth, options);
    std::map<std::uint32_t, FoundPlaneResult> found;
    std::map<std::uint32_t, double> most;
    std::map<int, std::set<std::uint32_t>> ids_of;
    std::map<int, std::set<std::int64_t>> stamps_of;
    std::vector<double> angles;
    std::vector<double> offsets;
    for (const PlaneRow& row : rows) {
        const PlaneMatch m = match(row, T_true_est, truth, samples, options);
        FoundPlaneResult& plane = found[row.id];
        plane.id = row.id;
        ++plane.keyframes;
        most[row.id] = std::max(most[row.id], row.landmarks);
        if (2.0 * row.landmarks > most[row.id]) {
            plane.last = m;
        }
        if (m.truth >= 0) {
            ++plane.right;
            angles.push_back(m.angle_deg);
            offsets.push_back(m.offset_m);
            ids_of[m.truth].insert(row.id);
            stamps_of[m.truth].insert(row.stamp.ns);
        }
    }
    for (const auto& [id, plane] : found) {
        result.found.push_back(plane);
        result.right += 2 * plane.right > plane.keyframes ? 1 : 0;
    }
    const TriangleTree tree(truth.surface);
    std::vector<double> seen_m2;
    for (std::size_t k = 0; k < truth.planes.size(); ++k) {
        TruePlaneResult t = look_at(truth.planes[k], samples[k], truth, tree, options);
        const int index = static_cast<int>(k);
        t.ids = static_cast<int>(ids_of[index].size());
        t.keyframes = static_cast<int>(stamps_of[index].size());
        result.wanted += t.is_wanted ? 1 : 0;
        result.wanted_found += t.is_wanted && t.keyframes > 0 ? 1 : 0;
        seen_m2.push_back(t.seen_m2);
        result.truths.push_back(t);
    }
    result.strict = judge_strictly(rows, surfaces, truth, tree, T_true_est, seen_m2, options.strict);
    result.told = rows.size();
    result.told_right = angles.size();
    result.good_angle = share_within(angles, options.good_angle_deg);
    result.good_offset = share_within(offsets, options.good_offset_m);
    const OrderStatistics by_angle(std::move(angles));
    const OrderStatistics by_offset(std::move(offsets));
    result.median_angle_deg = by_angle.quantile(0.5);
    result.p90_angle_deg = by_angle.quantile(0.9);
    result.median_offset_m = by_offset.quantile(0.5);
    result.p90_offset_m = by_offset.quantile(0.9);
    return result;
}

}  // namespace facet
