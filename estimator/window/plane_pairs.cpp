// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/plane_pairs.h"

#include <algorithm>
#include <cmath>

#include "estimator/factors/plane_pair_factor.h"
#include "platform/base/angle.h"

namespace facet {
namespace {

// Two planes within this angle of parallel or orthogonal are constrained as such (deg).
constexpr double kPairGate_deg = 3.0;
// Threshold of Cauchy's robust loss on these angles, in standard deviations: what is farther off loses weight.
constexpr double kPairThreshold = 1.0;
// Standard deviation of the angles of level, upright, parallel and orthogonal planes: how exact buildings are (deg).
constexpr double kPairSigma_deg = 0.3;
constexpr double kStay = 1.5;  // a pair's gate, once it is one

/// A side that stays fixed: its normal points up.
const Plane& vertical() {
    static const Plane kUpwards;
    return kUpwards;
}

PlaneSide side(const WindowPlanes& planes, int index) {
    if (index == PlanePair::kVertical) {
        return {&vertical(), &vertical()};
    }
    const WindowPlane& plane = planes[static_cast<std::size_t>(index)];
    return {&plane.plane, &plane.linearization_point()};
}

/// Whether a and b are, or remain, a pair of this kind.
bool is_pair(const WindowPlanes& planes, const PlanePair& pair, const PlanePairs& before, double gate_rad) {
    const Eigen::Vector3d n_a = side(planes, pair.a).plane->normal_W();
    const Eigen::Vector3d n_b = side(planes, pair.b).plane->normal_W();
    const double sine = pair.is_parallel ? n_a.cross(n_b).norm() : std::abs(n_a.dot(n_b));
    const bool was = std::find(before.begin(), before.end(), pair) != before.end();
    return sine < std::sin((was ? kStay : 1.0) * gate_rad);
}

}  // namespace

void find_plane_pairs(const WindowPlanes& planes, const RegularityConfig& config, PlanePairs& pairs) {
    const PlanePairs before = pairs;
    const double gate_rad = kPairGate_deg * kRadPerDeg;
    pairs.clear();
    const auto takes_part = [&](const WindowPlane& p) {
        return p.kind != PlaneKind::kSlanted && (p.is_bound || p.constraints >= config.min_constraints);
    };
    for (int a = 0; a < static_cast<int>(planes.size()); ++a) {
        const WindowPlane& plane = planes[static_cast<std::size_t>(a)];
        if (!takes_part(plane)) {
            continue;
        }
        const PlanePair level{a, PlanePair::kVertical, plane.kind == PlaneKind::kHorizontal};
        if (config.use_gravity && is_pair(planes, level, before, gate_rad)) {
            pairs.push_back(level);
        }
        for (int b = 0; config.use_pairs && b < a; ++b) {
            // The vertical already makes level planes parallel to each other, and orthogonal to walls.
            const WindowPlane& other = planes[static_cast<std::size_t>(b)];
            if (config.use_gravity && (plane.kind == PlaneKind::kHorizontal || other.kind == PlaneKind::kHorizontal)) {
                continue;
            }
            for (const bool is_parallel : {true, false}) {
                const PlanePair pair{a, b, is_parallel};
                if (takes_part(other) && is_pair(planes, pair, before, gate_rad)) {
                    pairs.push_back(pair);
                }
            }
        }
    }
}

double add_plane_pairs(const WindowPlanes& planes, const PlanePairs& pairs, int first_row, ReducedSystem& system) {
    double cost = 0.0;
    const double sigma_rad = kPairSigma_deg * kRadPerDeg;
    const CauchyLoss loss{kPairThreshold};
    auto h = system.h();
    auto g = system.g();
    for (const PlanePair& pair : pairs) {
        PlanePairLinearization l;
        const auto linearize = pair.is_parallel ? linearize_parallel : linearize_orthogonal;
        linearize(side(planes, pair.a), side(planes, pair.b), sigma_rad, loss, l);
        cost += l.cost;
        const int row_a = first_row + kPlaneDim * pair.a;
        const int row_b = first_row + kPlaneDim * pair.b;
        const bool has_b = pair.b != PlanePair::kVertical;
        g.segment<2>(row_a) += l.d_r_d_a.transpose() * l.r;
        if (has_b) {
            g.segment<2>(row_b) += l.d_r_d_b.transpose() * l.r;
        }
        if (!system.has_matrix()) {
            continue;
        }
        h.block<2, 2>(row_a, row_a) += l.d_r_d_a.transpose() * l.d_r_d_a;
        if (has_b) {  // b < a: the block stands below the diagonal
            h.block<2, 2>(row_b, row_b) += l.d_r_d_b.transpose() * l.d_r_d_b;
            h.block<2, 2>(row_a, row_b) += l.d_r_d_a.transpose() * l.d_r_d_b;
        }
    }
    return cost;
}

}  // namespace facet
