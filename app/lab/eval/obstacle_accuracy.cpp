// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/obstacle_accuracy.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/support/input_error.h"
#include "app/support/statistics.h"
#include "drivers/replay_asl/csv_file.h"

namespace facet {
namespace {

constexpr std::size_t kRayColumns = 11;  // the stamp and ten numbers

void count_ray(const RayRow& ray, double truth_m, const ObstacleEvalOptions& options, ObstacleShares& shares) {
    ++shares.rays;
    if (ray.free_m > truth_m + options.tolerance_m) {
        ++shares.missed;
    } else if (ray.free_m < truth_m - options.tolerance_m) {
        ++(ray.is_unknown ? shares.unknown : shares.false_obstacle);
    }
}

nlohmann::ordered_json shares_json(const ObstacleShares& s) {
    return {{"rays", s.rays},
            {"missed", s.share(s.missed)},
            {"false_obstacle", s.share(s.false_obstacle)},
            {"unknown", s.share(s.unknown)}};
}

}  // namespace

std::vector<RayRow> read_rays(const std::string& path) {
    CsvFile csv;
    if (!csv.open(path)) {
        throw InputError(path + ": cannot be read");
    }
    std::vector<RayRow> rays;
    std::vector<std::string_view> fields;
    while (csv.next(fields)) {
        if (fields.front() == "stamp_ns") {
            continue;
        }
        RayRow ray;
        std::array<double, kRayColumns - 1> v{};
        bool is_good = fields.size() == kRayColumns && parse_stamp(fields[0], ray.stamp.ns);
        for (std::size_t i = 0; i < v.size() && is_good; ++i) {
            is_good = parse_double(fields[i + 1], v[i]) && !std::isnan(v[i]);
        }
        ray.p_W = {v[0], v[1], v[2]};
        ray.direction = {v[3], v[4], v[5]};
        if (!is_good || !ray.p_W.allFinite() || std::abs(ray.direction.norm() - 1.0) > 1e-3) {
            throw InputError(fmt::format("{}:{}: not a ray of {} numbers", path, csv.line(), kRayColumns));
        }
        ray.is_in_view = v[6] != 0.0;
        ray.is_unknown = v[7] != 0.0;
        ray.free_m = v[8];
        ray.obstacle_m = v[9];
        rays.push_back(ray);
    }
    return rays;
}

ObstacleEvaluation evaluate_obstacles(const std::vector<RayRow>& rays, const std::vector<PosePair>& pairs,
                                      const TriangleSoup& scene, const ObstacleEvalOptions& options) {
    constexpr Duration kSame{1'000'000};  // stamps of other files may be rounded
    const TriangleTree tree(scene);
    ObstacleEvaluation result;
    std::vector<double> errors;
    for (const RayRow& ray : rays) {
        const auto pair = std::lower_bound(pairs.begin(), pairs.end(), ray.stamp + Duration{-kSame.ns},
                                           [](const PosePair& p, Timestamp stamp) { return p.stamp < stamp; });
        if (pair == pairs.end() || pair->stamp > ray.stamp + kSame) {
            ++result.without_truth;
            continue;
        }
        const Se3 T_true_est = pair->truth * pair->estimate.inverse();
        const double truth_m = tree.cast(T_true_est * ray.p_W, T_true_est.q * ray.direction, options.range_m);
        RayRow cut = ray;
        cut.free_m = std::min(ray.free_m, options.range_m);
        // A surface just beyond the range is not missed by reporting free space up to the range.
        count_ray(cut, truth_m, options, result.all);
        if (ray.is_in_view) {
            count_ray(cut, truth_m, options, result.in_view);
        }
        const double error_m = std::abs(ray.obstacle_m - truth_m);
        if (!ray.is_unknown && truth_m < options.range_m && error_m <= options.tolerance_m) {
            errors.push_back(error_m);
        }
    }
    result.hits = errors.size();
    const OrderStatistics statistics(std::move(errors));
    result.median_error_m = statistics.median();
    result.p90_error_m = statistics.quantile(0.9);
    return result;
}

std::string text_report(const ObstacleEvaluation& e) {
    std::string text = "\nObstacles of the live grid, by rays\n              rays  missed %  false %  unknown %\n";
    for (const auto& [name, s] : {std::pair{"all around", &e.all}, std::pair{"in view", &e.in_view}}) {
        text += fmt::format("  {:<11} {:5} {:9.2f} {:8.2f} {:10.1f}\n", name, s->rays, 100.0 * s->share(s->missed),
                            100.0 * s->share(s->false_obstacle), 100.0 * s->share(s->unknown));
    }
    return text + fmt::format("  distance      median error {:.3f} m, p90 {:.3f} m, of {} rays\n", e.median_error_m,
                              e.p90_error_m, e.hits);
}

std::string json_report(const ObstacleEvaluation& e) {
    const nlohmann::ordered_json json{
        {"all", shares_json(e.all)},          {"in_view", shares_json(e.in_view)}, {"hits", e.hits},
        {"median_error_m", e.median_error_m}, {"p90_error_m", e.p90_error_m},      {"without_truth", e.without_truth}};
    return json.dump(2);
}

}  // namespace facet
