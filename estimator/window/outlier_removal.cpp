// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/outlier_removal.h"

#include <limits>

namespace facet {
namespace {

/// Whitened distance of a measurement to the point's reprojection; infinite if the point is behind the camera.
double reprojection_distance(const CameraPose& camera, const ScaledWorldPoint& point, const Eigen::Vector2d& xy,
                             const Eigen::Matrix2d& whitening) {
    const Eigen::Vector3d q = camera.R_C_W * point.from(camera.p_W_C);
    if (!(q.z() > 0.0)) {
        return std::numeric_limits<double>::infinity();
    }
    return (whitening * (q.head<2>() / q.z() - xy)).norm();
}

}  // namespace

OutlierCount remove_outliers(double threshold_px, WindowState& state, const WindowCameras& cameras,
                             boost::container::static_vector<LandmarkId, kMaxFeatures>& rejected) {
    OutlierCount count;
    const int newest = static_cast<int>(state.keyframes.size()) - 1;
    state.landmarks.remove_if([&](Landmark& landmark) {
        if (!landmark.is_active) {
            return false;
        }
        const ScaledWorldPoint point(cameras.left(landmark.observations.front().keyframe), landmark.point);
        const int before = count.observations;
        bool newest_rejected = false;
        std::size_t kept = 0;
        for (std::size_t i = 0; i < landmark.observations.size(); ++i) {
            LandmarkObservation o = landmark.observations[i];
            const double left = reprojection_distance(cameras.left(o.keyframe), point, o.measurement.left_xy,
                                                      cameras.whitening_left(o));
            if (left > threshold_px * cameras.pixels_to_sigmas()) {
                ++count.observations;
                newest_rejected = newest_rejected || o.keyframe == newest;
                continue;
            }
            if (o.measurement.has_right) {
                const double right = reprojection_distance(cameras.right(o.keyframe), point, o.measurement.right_xy,
                                                           cameras.whitening_right(o));
                if (right > threshold_px * cameras.pixels_to_sigmas()) {
                    ++count.observations;
                    o.measurement.has_right = false;
                }
            }
            landmark.observations[kept++] = o;
        }
        if (count.observations == before) {
            return false;
        }
        landmark.observations.resize(kept);
        const bool remove = kept < 2;
        if (!remove) {
            const CameraPose& new_host = cameras.left(landmark.observations.front().keyframe);
            landmark.has_point = (new_host.R_C_W * point.from(new_host.p_W_C)).z() > 0.0;
            if (landmark.has_point) {
                landmark.point = point.in(new_host);
            }
        }
        if ((newest_rejected || remove) && rejected.size() < rejected.capacity()) {
            rejected.push_back(landmark.id);
        }
        count.landmarks += remove ? 1 : 0;
        return remove;
    });
    return count;
}

}  // namespace facet
