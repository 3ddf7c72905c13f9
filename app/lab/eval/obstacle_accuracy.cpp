// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/obstacle_accuracy.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "app/support/input_error.h"
#include "app/support/statistics.h"
#include "drivers/replay_asl/csv_file.h"

namespace facet {
namespace {

constexpr std::size_t kRayColumns = 13;  // the stamp and twelve numbers

enum class RayVerdict : std::uint8_t { kRight, kMissed, kFalse, kPhantom, kUnknown };

/// @param origin, direction  of the ray in the true world
RayVerdict judge(const RayRow& ray, double truth_m, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                 const ObstacleTruth& truth, const ObstacleEvalOptions& options) {
    if (ray.free_m > truth_m + options.tolerance_m) {
        return RayVerdict::kMissed;
    }
    if (ray.free_m >= truth_m - options.tolerance_m) {
        return RayVerdict::kRight;
    }
    if (ray.is_unknown) {
        return RayVerdict::kUnknown;
    }
    const bool is_near =
        truth.distance(origin + ray.free_m * direction, options.tolerance_m, ray.stamp) < options.tolerance_m;
    return is_near ? RayVerdict::kFalse : RayVerdict::kPhantom;
}

void count(RayVerdict verdict, ObstacleShares& shares) {
    ++shares.rays;
    shares.missed += verdict == RayVerdict::kMissed ? 1 : 0;
    shares.false_obstacle += verdict == RayVerdict::kFalse || verdict == RayVerdict::kPhantom ? 1 : 0;
    shares.phantom += verdict == RayVerdict::kPhantom ? 1 : 0;
    shares.unknown += verdict == RayVerdict::kUnknown ? 1 : 0;
}

nlohmann::ordered_json shares_json(const ObstacleShares& s) {
    return {{"rays", s.rays},
            {"missed", s.share(s.missed)},
            {"false_obstacle", s.share(s.false_obstacle)},
            {"phantom", s.share(s.phantom)},
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
        ray.certainty = v[10];
        ray.age_s = v[11];
        rays.push_back(ray);
    }
    return rays;
}

ObstacleEvaluation evaluate_obstacles(const std::vector<RayRow>& rays, const std::vector<PosePair>& pairs,
                                      const ObstacleTruth& truth, const ObstacleEvalOptions& options) {
    ObstacleEvaluation result;
    std::vector<double> errors;
    std::vector<double> phantom_ages;
    for (const RayRow& ray : rays) {
        const std::optional<Se3> T_true_est = alignment_at(pairs, ray.stamp);
        if (!T_true_est) {
            ++result.without_truth;
            continue;
        }
        const Eigen::Vector3d origin = *T_true_est * ray.p_W;
        const Eigen::Vector3d direction = T_true_est->q * ray.direction;
        const double truth_m = truth.cast(origin, direction, options.range_m, ray.stamp);
        // A surface just beyond the range is not missed by reporting free space up to the range.
        RayRow cut = ray;
        cut.free_m = std::min(ray.free_m, options.range_m);
        const RayVerdict verdict = judge(cut, truth_m, origin, direction, truth, options);
        count(verdict, result.all);
        if (ray.is_in_view) {
            count(verdict, result.in_view);
        }
        if (verdict == RayVerdict::kPhantom) {
            phantom_ages.push_back(ray.age_s);
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
    result.phantom_age_s = OrderStatistics(std::move(phantom_ages)).median();
    return result;
}

std::string text_report(const ObstacleEvaluation& e) {
    std::string text =
        "\nObstacles of the live grid, by rays\n              rays  missed %  false %  phantom %  unknown %\n";
    for (const auto& [name, s] : {std::pair{"all around", &e.all}, std::pair{"in view", &e.in_view}}) {
        text += fmt::format("  {:<11} {:5} {:9.2f} {:8.2f} {:10.2f} {:10.1f}\n", name, s->rays,
                            100.0 * s->share(s->missed), 100.0 * s->share(s->false_obstacle),
                            100.0 * s->share(s->phantom), 100.0 * s->share(s->unknown));
    }
    return text + fmt::format("  distance      median error {:.3f} m, p90 {:.3f} m, of {} rays\n", e.median_error_m,
                              e.p90_error_m, e.hits);
}

std::string json_report(const ObstacleEvaluation& e) {
    const nlohmann::ordered_json json{
        {"all", shares_json(e.all)},          {"in_view", shares_json(e.in_view)}, {"hits", e.hits},
        {"median_error_m", e.median_error_m}, {"p90_error_m", e.p90_error_m},      {"phantom_age_s", e.phantom_age_s},
        {"without_truth", e.without_truth}};
    return json.dump(2);
}

}  // namespace facet
