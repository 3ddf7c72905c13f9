// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/sweep_accuracy.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>

#include "app/support/input_error.h"
#include "app/support/statistics.h"
#include "drivers/replay_asl/csv_file.h"

namespace facet {
namespace {

constexpr std::size_t kPoseColumns = 6;
constexpr double kSectorWidth = 2.0 * std::numbers::pi / static_cast<double>(kSweepRowSectors);

/// Distance of the nearest sample in each sector and the band, both widened by a margin; at most the range.
std::array<double, kSweepRowSectors> true_ranges(const SweepRow& sweep, const Se3& T_true_est,
                                                 const std::vector<Eigen::Vector3d>& samples, double range_m,
                                                 double margin_m) {
    std::array<double, kSweepRowSectors> ranges{};
    ranges.fill(range_m);
    const Se3 T_est_true = T_true_est.inverse();
    const Eigen::Vector3d place = T_true_est * sweep.p_W;
    const double below_m = sweep.below_m + margin_m;
    const double above_m = sweep.above_m + margin_m;
    const double reach2 = range_m * range_m + std::max(below_m, above_m) * std::max(below_m, above_m);
    for (const Eigen::Vector3d& sample : samples) {
        if ((sample - place).squaredNorm() > reach2) {
            continue;
        }
        const Eigen::Vector3d d = T_est_true * sample - sweep.p_W;
        const double distance = d.head<2>().norm();
        if (d.z() < -below_m || d.z() > above_m || distance >= range_m) {
            continue;
        }
        const double clockwise = (sweep.ahead_rad - std::atan2(d.y(), d.x())) / kSectorWidth;
        const double half = margin_m / std::max(distance, margin_m + 1e-9) / kSectorWidth;
        const auto first = static_cast<long>(std::floor(clockwise - half + 0.5));
        const auto last = static_cast<long>(std::floor(clockwise + half + 0.5));
        constexpr auto kCount = static_cast<long>(kSweepRowSectors);
        for (long k = first; k <= last; ++k) {
            double& range = ranges[static_cast<std::size_t>((k % kCount + kCount) % kCount)];
            range = std::min(range, distance);
        }
    }
    return ranges;
}

}  // namespace

std::vector<SweepRow> read_sweeps(const std::string& path) {
    CsvFile csv;
    if (!csv.open(path)) {
        throw InputError(path + ": cannot be read");
    }
    std::vector<SweepRow> sweeps;
    std::vector<std::string_view> fields;
    while (csv.next(fields)) {
        if (fields.front() == "stamp_ns") {
            continue;
        }
        SweepRow row;
        std::array<double, kPoseColumns> v{};
        bool is_good = fields.size() == 1 + kPoseColumns + kSweepRowSectors && parse_stamp(fields[0], row.stamp.ns);
        for (std::size_t i = 0; i < v.size() && is_good; ++i) {
            is_good = parse_double(fields[i + 1], v[i]) && std::isfinite(v[i]);
        }
        for (std::size_t k = 0; k < kSweepRowSectors && is_good; ++k) {
            is_good = parse_double(fields[1 + kPoseColumns + k], row.range_m[k]) && !(row.range_m[k] < 0.0);
        }
        if (!is_good) {
            throw InputError(fmt::format("{}:{}: not a sweep of {} sectors", path, csv.line(), kSweepRowSectors));
        }
        row.p_W = {v[0], v[1], v[2]};
        row.ahead_rad = v[3];
        row.below_m = v[4];
        row.above_m = v[5];
        sweeps.push_back(row);
    }
    return sweeps;
}

SweepEvaluation evaluate_sweeps(const std::vector<SweepRow>& sweeps, const std::vector<PosePair>& pairs,
                                const ObstacleTruth& truth, const SweepEvalOptions& options) {
    SweepEvaluation result;
    std::vector<double> errors;
    for (const SweepRow& sweep : sweeps) {
        const std::optional<Se3> T_true_est = alignment_at(pairs, sweep.stamp);
        if (!T_true_est) {
            ++result.without_truth;
            continue;
        }
        const std::vector<Eigen::Vector3d> samples = truth.samples(sweep.stamp);
        const auto ranges = true_ranges(sweep, *T_true_est, samples, options.range_m, 0.0);
        const auto widened = true_ranges(sweep, *T_true_est, samples, options.range_m, options.margin_m);
        for (std::size_t k = 0; k < kSweepRowSectors; ++k) {
            ++result.sectors;
            if (std::isnan(sweep.range_m[k])) {
                ++result.unknown;
                continue;
            }
            const double reported = std::min(sweep.range_m[k], options.range_m);
            result.missed += reported > ranges[k] + options.tolerance_m ? 1 : 0;
            result.false_obstacle += reported < widened[k] - options.tolerance_m ? 1 : 0;
            if (reported < options.range_m && ranges[k] < options.range_m) {
                errors.push_back(std::abs(reported - ranges[k]));
            }
        }
    }
    result.hits = errors.size();
    const OrderStatistics statistics(std::move(errors));
    result.median_error_m = statistics.median();
    result.p90_error_m = statistics.quantile(0.9);
    return result;
}

std::string text_report(const SweepEvaluation& e) {
    return fmt::format(
        "  sweep       {:5} sectors: missed {:.2f} %, false {:.2f} %, unknown {:.1f} %; error of range median {:.3f} "
        "m, "
        "p90 {:.3f} m, of {}\n",
        e.sectors, 100.0 * e.share(e.missed), 100.0 * e.share(e.false_obstacle), 100.0 * e.share(e.unknown),
        e.median_error_m, e.p90_error_m, e.hits);
}

std::string json_report(const SweepEvaluation& e) {
    const nlohmann::ordered_json json{{"sectors", e.sectors},
                                      {"missed", e.share(e.missed)},
                                      {"false_obstacle", e.share(e.false_obstacle)},
                                      {"unknown", e.share(e.unknown)},
                                      {"hits", e.hits},
                                      {"median_error_m", e.median_error_m},
                                      {"p90_error_m", e.p90_error_m},
                                      {"without_truth", e.without_truth}};
    return json.dump(2);
}

}  // namespace facet
