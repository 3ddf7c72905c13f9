// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/strict_planes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "platform/base/angle.h"

namespace facet {
namespace {

/// How much of an estimate's surface is true, and how many squares are on each true plane.
struct Cover {
    double share = 0.0;
    std::map<int, int> squares_on;
};

Cover cover(const PlaneSurface& surface, const SceneTruth& truth, const TriangleTree& tree, const Se3& T_true_est,
            const StrictOptions& options) {
    const Eigen::Vector3d n = T_true_est.q * surface.normal;
    const double least_cosine = std::cos(options.angle_deg * kRadPerDeg);
    Cover cover;
    int covered = 0;
    for (const Eigen::Vector3d& square : surface.squares) {
        const TriangleTree::Nearest nearest = tree.nearest(T_true_est * square, options.offset_m);
        if (nearest.triangle < 0) {
            continue;
        }
        const Eigen::Vector3d true_n = truth.surface.normal(static_cast<std::size_t>(nearest.triangle));
        if (n.dot(true_n) < least_cosine) {
            continue;
        }
        ++covered;
        if (const int plane = plane_at(truth.planes, nearest.point, true_n); plane >= 0) {
            ++cover.squares_on[plane];
        }
    }
    cover.share = surface.squares.empty() ? 0.0 : covered / static_cast<double>(surface.squares.size());
    return cover;
}

/// Of the true planes under the estimate the one with most squares that the row agrees with; -1 if none.
int match(const PlaneRow& row, const Cover& cover, const SceneTruth& truth, const Se3& T_true_est,
          const StrictOptions& options) {
    const Eigen::Vector3d n = T_true_est.q * row.normal;
    const Eigen::Vector3d c = T_true_est * row.centroid;
    const double least_cosine = std::cos(options.angle_deg * kRadPerDeg);
    int best = -1;
    int most = 0;
    for (const auto& [index, squares] : cover.squares_on) {
        const EvalPlane& plane = truth.planes[static_cast<std::size_t>(index)];
        if (squares > most && n.dot(plane.normal) >= least_cosine &&
            std::abs(plane.normal.dot(c) - plane.distance) <= options.offset_m) {
            best = index;
            most = squares;
        }
    }
    return best;
}

/// An estimate by itself: all but whether another one is of the same plane.
StrictVerdict judge_one(const std::vector<const PlaneRow*>& rows, const PlaneSurface& surface, const SceneTruth& truth,
                        const TriangleTree& tree, const Se3& T_true_est, const StrictOptions& options) {
    StrictVerdict verdict;
    verdict.id = rows.front()->id;
    verdict.keyframes = static_cast<int>(rows.size());
    const Cover under = cover(surface, truth, tree, T_true_est, options);
    verdict.share = under.share;
    std::map<int, int> counts;
    for (const PlaneRow* row : rows) {
        ++counts[match(*row, under, truth, T_true_est, options)];
    }
    for (const auto& [index, count] : counts) {
        if (index >= 0 && count > verdict.right) {
            verdict.truth = index;
            verdict.right = count;
        }
    }
    verdict.cause = verdict.share < options.overlap          ? StrictCause::kNoSurface
                    : 2 * verdict.right <= verdict.keyframes ? StrictCause::kOff
                                                             : StrictCause::kRight;
    return verdict;
}

/// The true plane with most squares near the estimate, within limits so wide that it is surely meant; -1 if none.
int nearest_plane(const PlaneSurface& surface, const SceneTruth& truth, const TriangleTree& tree,
                  const Se3& T_true_est) {
    const Cover near = cover(surface, truth, tree, T_true_est, {.angle_deg = 10.0, .offset_m = 0.15});
    const auto most = std::max_element(near.squares_on.begin(), near.squares_on.end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
    return most != near.squares_on.end() ? most->first : -1;
}

}  // namespace

const char* to_string(StrictCause cause) {
    switch (cause) {
        case StrictCause::kRight: return "right";
        case StrictCause::kNoSurface: return "no surface";
        case StrictCause::kOff: return "off";
        case StrictCause::kDuplicate: return "duplicate";
    }
    return "";
}

StrictPlanes judge_strictly(const std::vector<PlaneRow>& rows, const std::optional<PlaneSurfaces>& surfaces,
                            const SceneTruth& truth, const TriangleTree& tree, const Se3& T_true_est,
                            const std::vector<double>& seen_m2, const StrictOptions& options) {
    std::map<std::uint32_t, std::vector<const PlaneRow*>> rows_of;
    for (const PlaneRow& row : rows) {
        rows_of[row.id].push_back(&row);
    }
    std::set<int> owned;
    StrictPlanes strict;
    for (const auto& [id, own] : rows_of) {
        if (surfaces.has_value() && surfaces->count(id) == 0) {
            ++strict.taken_back;
            continue;
        }
        const PlaneSurface* const known = surfaces.has_value() ? &surfaces->at(id) : nullptr;
        const auto by_area = [](const PlaneRow* a, const PlaneRow* b) { return a->area_m2 < b->area_m2; };
        const PlaneSurface surface =
            known != nullptr && known->has_regions
                ? *known
                : disc_of(**std::max_element(own.begin(), own.end(), by_area), options.wanted_seen_m2);
        StrictVerdict verdict = judge_one(own, surface, truth, tree, T_true_est, options);
        if (verdict.cause == StrictCause::kRight && !owned.insert(verdict.truth).second) {
            verdict.cause = StrictCause::kDuplicate;
        }
        verdict.truth = verdict.truth >= 0 ? verdict.truth : nearest_plane(surface, truth, tree, T_true_est);
        if (verdict.truth >= 0 && known != nullptr && known->claim.has_value()) {
            verdict.error = error_of(*known->claim, truth.planes[static_cast<std::size_t>(verdict.truth)], T_true_est);
        }
        const bool is_covered = verdict.error.has_value() && verdict.error->sigmas.cwiseAbs().maxCoeff() <= 3.0;
        strict.confident += verdict.cause != StrictCause::kRight && !is_covered ? 1 : 0;
        strict.verdicts.push_back(verdict);
    }
    strict.found = static_cast<int>(strict.verdicts.size());
    strict.right = static_cast<int>(owned.size());
    for (std::size_t k = 0; k < seen_m2.size(); ++k) {
        if (seen_m2[k] < options.wanted_seen_m2) {
            continue;
        }
        const bool is_found = owned.count(static_cast<int>(k)) > 0;
        ++strict.wanted;
        strict.wanted_m2 += seen_m2[k];
        strict.wanted_found += is_found ? 1 : 0;
        strict.found_m2 += is_found ? seen_m2[k] : 0.0;
    }
    return strict;
}

}  // namespace facet
