// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/estimate_queue.h"

#include <utility>

namespace facet {

EstimateQueue::EstimateQueue() {
    for (ViewMesh& mesh : pool_) {
        reserve_most(mesh);
    }
}

void EstimateQueue::offer_mesh(Timestamp stamp, const Fillers& fillers) {
    Mesh mesh{stamp, slots_.take()};
    if (!mesh.slot.held()) {
        count_dropped(Status::kFull);
        return;
    }
    refill(fillers.mesh, pool_[static_cast<std::size_t>(mesh.slot.slot())]);
    count_dropped(meshes_.push(std::move(mesh)));
    next_mesh_ = stamp + kMeshPeriod;
}

void EstimateQueue::offer(const ViewState& state, const Fillers& fillers) {
    newest_ = state.stamp;
    count_dropped(states_.push(state));
    if (fillers.mesh && state.stamp >= next_mesh_) {
        offer_mesh(state.stamp, fillers);
    }
    if (fillers.calibration) {
        Calibration calibration{state.stamp, {}};
        fillers.calibration(calibration.estimate);
        count_dropped(calibrations_.push(std::move(calibration)));
        next_calibration_ = state.stamp + kCalibrationPeriod;
    }
}

void EstimateQueue::pass_on(EstimateChannels& channels) {
    for (ViewState state; ok(states_.pop(state));) {
        channels.add(state);
    }
    for (Mesh mesh; ok(meshes_.pop(mesh)); mesh = {}) {
        channels.add(mesh.stamp, pool_[static_cast<std::size_t>(mesh.slot.slot())]);
    }
    for (Calibration calibration; ok(calibrations_.pop(calibration));) {
        channels.add(calibration.stamp, calibration.estimate);
    }
}

}  // namespace facet
