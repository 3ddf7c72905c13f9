// SPDX-License-Identifier: BSD-2-Clause
// By how much images turn, whatever the gyroscope says.
#include <Eigen/Cholesky>
#include <algorithm>

#include "estimator/frontend/frontend_impl.h"
#include "estimator/geometry/so3.h"

namespace facet {
namespace {

constexpr int kFewestFlows = 20;
constexpr double kFlowScale_px = 1.0;  // Cauchy's
constexpr int kFlowSteps = 5;
// Prior of the camera's way between two frames over the depth, as a share: keeps it where depths say nothing.
constexpr double kWayPrior = 0.02;

}  // namespace

void Frontend::Impl::measure_turn(FrontendOutput& output) {
    // Beyond the gyroscope's turn, a camera that turns by phi and moves by m sees a point of inverse depth rho move by
    //   (-phi_y + phi_z y + x phi_x y - x^2 phi_y, phi_x - phi_z x + y^2 phi_x - x y phi_y) + rho (m_z xy - m_xy).
    using Row = Eigen::Matrix<double, 2, 6>;
    const double usual = median_inverse_depth();
    const double focal_px = rig.left.focal_px();
    const auto followed = [this](int frames) {
        return std::ranges::count_if(tracks, [=](const Track& t) { return t.unseen == 0 && t.span == frames; });
    };
    int span = 1;
    for (int frames = 2; frames <= kMaxTurns; ++frames) {
        span = followed(frames) > followed(span) ? frames : span;
    }
    const double dt_s = motion_since(span).dt_s;
    Eigen::Matrix<double, 6, 1> solution = Eigen::Matrix<double, 6, 1>::Zero();
    int flows = 0;
    for (int step = 0; step < kFlowSteps; ++step) {
        Eigen::Matrix<double, 6, 6> h = Eigen::Matrix<double, 6, 6>::Zero();
        Eigen::Matrix<double, 6, 1> g = Eigen::Matrix<double, 6, 1>::Zero();
        h.diagonal().head<3>().setConstant(1e-6);
        h.diagonal().tail<3>().setConstant(1.0 / (kWayPrior * kWayPrior));
        flows = 0;
        for (const Track& track : tracks) {
            if (track.unseen != 0 || track.span != span || !track.has_velocity) {
                continue;
            }
            const double x = track.xy.x();
            const double y = track.xy.y();
            const double rho = track.has_depth ? track.inverse_depth : usual;
            Row row;
            row << x * y, -1.0 - x * x, y, -rho, 0.0, rho * x,  //
                1.0 + y * y, -x * y, -x, 0.0, -rho, rho * y;
            row *= focal_px;
            const Eigen::Vector2d flow = focal_px * dt_s * track.velocity;
            const double error2 = (flow - row * solution).squaredNorm() / (kFlowScale_px * kFlowScale_px);
            const double w = step == 0 ? 1.0 : 1.0 / (1.0 + error2);
            h += w * row.transpose() * row;
            g += w * row.transpose() * flow;
            ++flows;
        }
        if (flows < kFewestFlows) {
            return;
        }
        solution = h.ldlt().solve(g);
    }
    const Sight& begin = sights[static_cast<std::size_t>(span)];
    output.has_turn = true;
    output.turn_begin = begin.stamp;
    output.turn_B =
        so3_log((begin.q_B0_B.conjugate() * sights[0].q_B0_B).normalized()) + rig.T_B_C0.q * solution.head<3>();
}

}  // namespace facet
