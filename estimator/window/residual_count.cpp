// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/residual_count.h"

namespace facet {
namespace {

void count(const RelativeView& view, const InverseDepthPoint& point, const Eigen::Vector2d& xy,
           const Eigen::Matrix2f& d_uv_d_xy, ResidualHistogram& u, ResidualHistogram& v, ResidualsByAngle& by_angle) {
    const Eigen::Vector3d q = view.sight_line(point);
    if (is_in_front(q)) {
        const Eigen::Vector2d r = d_uv_d_xy.cast<double>() * (q.hnormalized() - xy);
        u.add(r.x());
        v.add(r.y());
        by_angle.add(xy, r);
    }
}

}  // namespace

void count_oldest_residuals(const WindowState& state, const WindowCameras& cameras, VisionResiduals& residuals) {
    const StereoView& view = cameras.view(0, 0);
    for (int i = 0; i < state.landmarks.size(); ++i) {
        const Landmark& landmark = state.landmarks[i];
        if (!landmark.is_active || !landmark.has_point || landmark.observations.front().keyframe != 0) {
            continue;
        }
        const StereoMeasurement& z = landmark.observations.front().measurement;
        count(view.left, landmark.point, z.left_xy, z.d_left_d_xy, residuals.left_u, residuals.left_v,
              residuals.left_by_angle);
        if (z.has_right) {
            count(view.right, landmark.point, z.right_xy, z.d_right_d_xy, residuals.right_u, residuals.right_v,
                  residuals.right_by_angle);
        }
    }
}

}  // namespace facet
