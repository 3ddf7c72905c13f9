// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/replay/turned_truth.h"

#include <vector>

#include "app/support/input_error.h"
#include "app/support/text_file.h"
#include "drivers/replay_asl/ground_truth.h"
#include "estimator/geometry/so3.h"

namespace facet {
namespace {

void print(TextFile& file, const Eigen::Vector3d& v) { file.print(",{:.9f},{:.9f},{:.9f}", v.x(), v.y(), v.z()); }

}  // namespace

void write_turned_truth(const std::string& dataset, FaultInjector& injector, const std::string& path) {
    const std::string table = injector.turns_images() ? find_ground_truth(dataset) : "";
    if (table.empty()) {
        return;
    }
    std::vector<GroundTruthState> states;
    std::string error;
    if (!ok(read_ground_truth(table, {}, states, error))) {
        throw InputError(error);
    }
    TextFile file(path);
    file.write("#timestamp [ns], p x y z [m], q w x y z [], v x y z [m/s], b_w x y z [rad/s], b_a x y z [m/s^2]\n");
    for (const GroundTruthState& state : states) {
        const Eigen::Quaterniond q = state.q_W_B * so3_exp(injector.turn_at(state.stamp));
        file.print("{}", state.stamp.ns);
        print(file, state.p_W_B);
        file.print(",{:.9f},{:.9f},{:.9f},{:.9f}", q.w(), q.x(), q.y(), q.z());
        if (state.has_motion) {
            print(file, state.v_W_B);
            print(file, state.gyro_bias);
            print(file, state.accel_bias);
        }
        file.write("\n");
    }
    file.close();
}

}  // namespace facet
