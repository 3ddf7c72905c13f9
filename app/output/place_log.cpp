// SPDX-License-Identifier: BSD-2-Clause
#include "app/output/place_log.h"

#include <cmath>

#include "app/output/trajectory_writer.h"

namespace facet {

PlaceLog::PlaceLog(const std::string& folder)
    : places_(folder + "/places.csv"), trajectory_(folder + "/trajectory_map.tum") {
    places_.write(
        "stamp_ns,place_stamp_ns,accepted,matches,inliers,yaw,x,y,z,yaw_sigma,place_sigma,located,map_yaw,map_x,map_y,"
        "map_z\n");
}

void PlaceLog::write(const Estimate& estimate, bool is_usable, const PlaceMemory& places) {
    const YawPose T_M_O = places.map_from_odom();
    if (places.counters().stations != stations_) {
        stations_ = places.counters().stations;
        const auto end_row = [&] {
            places_.print(",{},{:.9f},{:.9f},{:.9f},{:.9f}\n", places.is_located() ? 1 : 0, T_M_O.yaw, T_M_O.p.x(),
                          T_M_O.p.y(), T_M_O.p.z());
        };
        for (const Recognition& r : places.recognitions()) {
            const YawPose& pose = r.pose.T_K_G;
            places_.print("{},{},{},{},{},{:.9f},{:.9f},{:.9f},{:.9f},{:.3e},{:.3e}", r.stamp.ns, r.place_stamp.ns,
                          r.is_accepted ? 1 : 0, r.pose.matches, r.pose.inliers, pose.yaw, pose.p.x(), pose.p.y(),
                          pose.p.z(), std::sqrt(r.pose.covariance(0, 0)),
                          std::sqrt(r.pose.covariance.diagonal().tail<3>().sum()));
            end_row();
        }
        if (places.recognitions().empty()) {
            places_.print("{},,0,0,0,0,0,0,0,0,0", places.station_stamp().ns);
            end_row();
        }
    }
    if (is_usable && places.is_located()) {
        const Se3 T_M_B = T_M_O * Se3{estimate.state.q_W_B, estimate.state.p_W_B};
        trajectory_.write(tum_line(estimate.stamp, T_M_B));
    }
}

void PlaceLog::close() {
    places_.close();
    trajectory_.close();
}

}  // namespace facet
