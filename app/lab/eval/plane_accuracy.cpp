// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/plane_accuracy.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <utility>

#include "app/support/input_error.h"
#include "app/support/statistics.h"
#include "drivers/replay_asl/csv_file.h"
#include "platform/base/angle.h"

namespace facet {
namespace {

constexpr std::array kColumns{"stamp_ns",  "id",      "nx", "ny", "nz", "distance_m",
                              "landmarks", "area_m2", "cx", "cy", "cz"};

PlaneRow row_of(const std::array<double, kColumns.size()>& v, Timestamp stamp) {
    PlaneRow row;
    row.stamp = stamp;
    row.id = static_cast<std::uint32_t>(v[1]);
    row.normal = {v[2], v[3], v[4]};
    row.distance = v[5];
    row.landmarks = v[6];
    row.area_m2 = v[7];
    row.centroid = {v[8], v[9], v[10]};
    return row;
}

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

/// The true plane that a report matches strictly, the nearest; -1 if none.
int match_strictly(const PlaneRow& row, const Se3& T_true_est, const SceneTruth& truth,
                   const std::vector<std::vector<Eigen::Vector3d>>& samples, const PlaneEvalOptions& options) {
    const Eigen::Vector3d n = T_true_est.q * row.normal;
    const Eigen::Vector3d c = T_true_est * row.centroid;
    const double least_cosine = std::cos(options.strict_angle_deg * kRadPerDeg);
    const double disc_m2 = std::max(row.area_m2, options.strict_seen_m2);
    const double squared_radius = disc_m2 / std::numbers::pi;
    int best = -1;
    double nearest = options.strict_offset_m;
    for (std::size_t k = 0; k < truth.planes.size(); ++k) {
        const double offset = std::abs(truth.planes[k].normal.dot(c) - truth.planes[k].distance);
        if (offset > nearest || n.dot(truth.planes[k].normal) < least_cosine) {
            continue;
        }
        const auto under = std::count_if(samples[k].begin(), samples[k].end(), [&](const Eigen::Vector3d& p) {
            return (p - c).squaredNorm() < squared_radius;
        });
        if (static_cast<double>(under) > options.strict_overlap * disc_m2 * options.samples_per_m2) {
            nearest = offset;
            best = static_cast<int>(k);
        }
    }
    return best;
}

/// @param matches  of each found plane: how often each true plane was matched strictly, -1 for none
StrictPlanes judge_strictly(const std::map<std::uint32_t, std::map<int, int>>& matches,
                            const std::vector<TruePlaneResult>& truths, const PlaneEvalOptions& options) {
    std::set<int> owned;
    for (const auto& [id, counts] : matches) {
        int total = 0;
        for (const auto& [plane, count] : counts) {
            total += count;
        }
        const auto most = std::max_element(counts.begin(), counts.end(),
                                           [](const auto& a, const auto& b) { return a.second < b.second; });
        if (most->first >= 0 && 2 * most->second > total) {
            owned.insert(most->first);
        }
    }
    StrictPlanes strict;
    strict.found = static_cast<int>(matches.size());
    strict.right = static_cast<int>(owned.size());
    for (std::size_t k = 0; k < truths.size(); ++k) {
        if (truths[k].seen_m2 < options.strict_seen_m2) {
            continue;
        }
        const bool is_found = owned.count(static_cast<int>(k)) > 0;
        ++strict.wanted;
        strict.wanted_m2 += truths[k].seen_m2;
        strict.wanted_found += is_found ? 1 : 0;
        strict.found_m2 += is_found ? truths[k].seen_m2 : 0.0;
    }
    return strict;
}

double share_within(const std::vector<double>& values, double limit) {
    const auto within = std::count_if(values.begin(), values.end(), [=](double v) { return v <= limit; });
    return values.empty() ? 0.0 : static_cast<double>(within) / static_cast<double>(values.size());
}

}  // namespace

std::vector<PlaneRow> read_planes(const std::string& path) {
    CsvFile csv;
    if (!csv.open(path)) {
        throw InputError(path + ": cannot be read");
    }
    std::vector<std::string_view> fields;
    std::array<std::size_t, kColumns.size()> at{};
    if (csv.next(fields)) {
        for (std::size_t i = 0; i < kColumns.size(); ++i) {
            const auto found = std::find(fields.begin(), fields.end(), kColumns[i]);
            if (found == fields.end()) {
                throw InputError(fmt::format("{}:{}: no column {}", path, csv.line(), kColumns[i]));
            }
            at[i] = static_cast<std::size_t>(found - fields.begin());
        }
    }
    const std::size_t columns = fields.size();
    std::vector<PlaneRow> rows;
    while (csv.next(fields)) {
        std::array<double, kColumns.size()> values{};
        Timestamp stamp;
        bool is_good = fields.size() == columns && parse_int64(fields[at[0]], stamp.ns);
        for (std::size_t i = 1; i < kColumns.size() && is_good; ++i) {
            is_good = parse_double(fields[at[i]], values[i]) && std::isfinite(values[i]);
        }
        if (!is_good) {
            throw InputError(fmt::format("{}:{}: not a row of planes", path, csv.line()));
        }
        rows.push_back(row_of(values, stamp));
    }
    return rows;
}

PlaneEvaluation evaluate_planes(const std::vector<PlaneRow>& rows, const SceneTruth& truth, const Se3& T_true_est,
                                const PlaneEvalOptions& options) {
    PlaneEvaluation result;
    const std::vector<std::vector<Eigen::Vector3d>> samples = sample_planes(truth, options);
    std::map<std::uint32_t, FoundPlaneResult> found;
    std::map<std::uint32_t, double> most;
    std::map<std::uint32_t, std::map<int, int>> strict_matches;
    std::map<int, std::set<std::uint32_t>> ids_of;
    std::map<int, std::set<std::int64_t>> stamps_of;
    std::vector<double> angles;
    std::vector<double> offsets;
    for (const PlaneRow& row : rows) {
        const PlaneMatch m = match(row, T_true_est, truth, samples, options);
        ++strict_matches[row.id][match_strictly(row, T_true_est, truth, samples, options)];
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
    for (std::size_t k = 0; k < truth.planes.size(); ++k) {
        TruePlaneResult t = look_at(truth.planes[k], samples[k], truth, tree, options);
        const int index = static_cast<int>(k);
        t.ids = static_cast<int>(ids_of[index].size());
        t.keyframes = static_cast<int>(stamps_of[index].size());
        result.wanted += t.is_wanted ? 1 : 0;
        result.wanted_found += t.is_wanted && t.keyframes > 0 ? 1 : 0;
        result.truths.push_back(t);
    }
    result.strict = judge_strictly(strict_matches, result.truths, options);
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
