// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/plane_gravity.h"

#include <cmath>

#include "estimator/factors/plane_gravity_factor.h"
#include "platform/base/angle.h"

namespace facet {
namespace {

// A plane within this angle of level or upright is constrained as such (deg).
constexpr double kAlignmentGate_deg = 3.0;
constexpr double kStay = 1.5;  // the gate of a plane that is aligned already, in gates
// How exact buildings are (deg), with Cauchy's loss from one standard deviation on: what is farther off loses weight.
constexpr double kAlignmentSigma_deg = 0.3;
constexpr CauchyLoss kAlignmentLoss{1.0};

}  // namespace

void align_planes(const RegularityConfig& config, WindowPlanes& planes) {
    const double gate_rad = kAlignmentGate_deg * kRadPerDeg;
    for (WindowPlane& plane : planes) {
        const Eigen::Vector3d n = plane.plane.normal_W();
        const double sine = plane.kind == PlaneKind::kHorizontal ? n.head<2>().norm() : std::abs(n.z());
        const bool is_held = plane.is_bound || plane.constraints >= RegularityConfig::kMinConstraints;
        plane.is_aligned = config.use_gravity && plane.kind != PlaneKind::kSlanted && is_held &&
                           sine < std::sin((plane.is_aligned ? kStay : 1.0) * gate_rad);
    }
}

double add_plane_gravity(const WindowPlanes& planes, int first_row, ReducedSystem& system) {
    double cost = 0.0;
    const double sigma_rad = kAlignmentSigma_deg * kRadPerDeg;
    auto h = system.h();
    auto g = system.g();
    int row = first_row;
    for (const WindowPlane& plane : planes) {
        if (plane.is_aligned) {
            PlaneGravityLinearization l;
            const auto linearize = plane.kind == PlaneKind::kHorizontal ? linearize_level : linearize_upright;
            linearize(plane.plane, plane.linearization_point(), sigma_rad, kAlignmentLoss, l);
            cost += l.cost;
            g.segment<2>(row) += l.d_r_d_v.transpose() * l.r;
            if (system.has_matrix()) {
                h.block<2, 2>(row, row) += l.d_r_d_v.transpose() * l.d_r_d_v;
            }
        }
        row += kPlaneDim;
    }
    return cost;
}

}  // namespace facet
