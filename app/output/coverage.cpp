// SPDX-License-Identifier: BSD-2-Clause
#include "app/output/coverage.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

namespace facet {
namespace {

struct LostFrames {
    std::size_t count;
    const char* where;
};

/// Frames without an estimate by what became of them, most first.
std::string whereabouts(const RunSummary& s) {
    const std::size_t given = std::min(s.frames, s.frames_listed - std::min(s.frames_listed, s.rows_skipped));
    const std::size_t spent = s.estimates + s.frames_refused + s.frames_not_ready;
    const auto uncovered_kind = s.warnings.find("uncovered_frame");
    const std::size_t absent = s.frames_listed - s.rows_skipped - given;
    const std::size_t uncovered = uncovered_kind == s.warnings.end() ? 0 : std::min(absent, uncovered_kind->second);
    std::vector<LostFrames> lost{
        {s.rows_skipped, "rows of cam0/data.csv skipped"},
        {uncovered, "outside the time of the inertial samples (are both on one clock?)"},
        {absent - uncovered, "did not come (image missing, damaged, of another size, or a fault)"},
        {s.frames_refused, "refused by the estimator for their stamps or size"},
        {s.frames_not_ready, "without inertial samples up to their stamp"},
        {s.frames - std::min(s.frames, spent), "while the estimator was starting or lost"}};
    std::ranges::stable_sort(lost, std::greater(), &LostFrames::count);
    std::string text;
    for (const LostFrames& part : lost) {
        if (part.count > 0) {
            text += fmt::format("{}{} {}", text.empty() ? "" : ", ", part.count, part.where);
        }
    }
    return text;
}

}  // namespace

std::string describe_lost_coverage(const RunSummary& s, double min_coverage) {
    if (s.estimates == 0) {
        return fmt::format("no estimate at all of {} frames: {}", s.frames_listed, whereabouts(s));
    }
    const std::size_t before = std::min(s.frames_before_estimate, s.frames_listed - s.estimates);
    const double since = static_cast<double>(s.estimates) / static_cast<double>(s.frames_listed - before);
    if (since >= min_coverage && s.coverage() >= 0.5 * min_coverage) {
        return {};
    }
    return fmt::format("only {} of {} frames have an estimate, {:.1f} % of those since the first: {}", s.estimates,
                       s.frames_listed, 100.0 * since, whereabouts(s));
}

std::string describe_contradiction(const RunSummary& s) {
    const std::size_t since = s.frames - std::min(s.frames, s.frames_before_estimate);
    if (2 * s.frames_contradicted <= since) {
        return {};
    }
    return fmt::format(
        "images and inertial samples contradict each other in {} of {} frames: a sensor, its axes or its calibration "
        "is wrong{}",
        s.frames_contradicted, since,
        s.frames_fixed_pattern > 0 ? ", or the pattern that was seen to move with the vehicle hides the world" : "");
}

}  // namespace facet
