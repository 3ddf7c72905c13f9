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

/// The true plane that an estimate is of, by all its rows; -1 if none.
int truth_of(const std::vector<const PlaneRow*>& rows, const PlaneSurface& surface, const SceneTruth& truth,
             const TriangleTree& tree, const Se3& T_true_est, const StrictOptions& options) {
    const Cover under = cover(surface, truth, tree, T_true_est, options);
    if (under.share < options.overlap) {
        return -1;
    }
    std::map<int, std::size_t> counts;
    for (const PlaneRow* row : rows) {
        ++counts[match(*row, under, truth, T_true_est, options)];
    }
    const auto most = std::max_element(counts.begin(), counts.end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
    return 2 * most->second > rows.size() ? most->first : -1;
}

}  // namespace

StrictPlanes judge_strictly(const std::vector<PlaneRow>& rows, const PlaneSurfaces& surfaces, const SceneTruth& truth,
                            const TriangleTree& tree, const Se3& T_true_est, const std::vector<double>& seen_m2,
                            const StrictOptions& options) {
    std::map<std::uint32_t, std::vector<const PlaneRow*>> rows_of;
    for (const PlaneRow& row : rows) {
        rows_of[row.id].push_back(&row);
    }
    std::set<int> owned;
    for (const auto& [id, own] : rows_of) {
        const auto known = surfaces.find(id);
        const auto by_area = [](const PlaneRow* a, const PlaneRow* b) { return a->area_m2 < b->area_m2; };
        const PlaneSurface surface =
            known != surfaces.end()
                ? known->second
                : disc_of(**std::max_element(own.begin(), own.end(), by_area), options.wanted_seen_m2);
        if (const int plane = truth_of(own, surface, truth, tree, T_true_est, options); plane >= 0) {
            owned.insert(plane);
        }
    }
    StrictPlanes strict;
    strict.found = static_cast<int>(rows_of.size());
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
