// SPDX-License-Identifier: BSD-2-Clause
// Estimator, mesh, planes and free space in a program of your own. Its vehicle moves to and fro two metres in front of a
// wall.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "made_up_wall.h"
#include "mesh/mapping/mapping.h"

int main() {
    // Body frame (IMU): x forward, y left, z up. Camera frames: z forward, x right, y down.
    const MadeUpWall wall;
    const facet::CameraModel camera(
        {wall.kWidth, wall.kHeight, wall.kFocal_px, wall.kFocal_px, 0.5 * (wall.kWidth - 1), 0.5 * (wall.kHeight - 1)});
    const Eigen::Quaterniond q_B_C(0.5, -0.5, 0.5, -0.5);  // w, x, y, z
    const facet::StereoRig rig{camera, camera, {q_B_C, {0.0, 0.05, 0.0}}, {q_B_C, {0.0, -0.05, 0.0}}};

    facet::MappingConfig config;  // the defaults, but planes become part of the estimate
    config.regularity.mode = facet::RegularityMode::kSpr;
    facet::Mapping mapping;
    if (!ok(mapping.configure(config, rig))) {
        return 1;
    }
    mapping.keep_grid();

    facet::Estimate estimate;
    double worst_m = 0.0;
    for (std::int64_t i = 0; i < 1600; ++i) {  // eight seconds: inertial samples at 200 Hz, frames at 20 Hz
        const facet::Timestamp now{i * 5'000'000};
        if (!ok(mapping.add_imu({now, {0.0, 0.0, 0.0}, {0.0, wall.acceleration_m_per_s2(now.seconds()), 9.81}}))) {
            return 1;
        }
        if (i % 10 != 0) {
            continue;
        }
        const facet::StereoFrame frame = wall.frame(now - facet::Duration{2'000'000});  // samples reach beyond it
        if (ok(mapping.add_frame(frame, estimate)) && is_usable(estimate.health.state)) {
            worst_m = std::max(worst_m, (estimate.state.p_W_B - wall.position_W(frame.stamp.seconds())).norm());
        }
        mapping.finish_frame(frame, estimate);  // when the estimate is on its way: mesh, planes, grid
    }
    std::printf("%s, position within %.1f mm; faces: %d\n", to_string(estimate.health.state), 1e3 * worst_m,
                mapping.mesher().mesh().face_count());
    for (const facet::TrackedPlane& plane : mapping.planes().planes()) {
        std::printf("plane with normal (%.3f, %.3f, %.3f), %.3f m away\n", plane.fit.normal_W.x(),
                    plane.fit.normal_W.y(), plane.fit.normal_W.z(), std::abs(plane.fit.distance_m));
    }
}
