// SPDX-License-Identifier: BSD-2-Clause
// Estimates on their way from the estimator's thread into a log.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>

#include "app/pipeline/estimate_channels.h"
#include "app/view/flight_viewer.h"
#include "platform/base/slot_lease.h"
#include "platform/base/spsc_queue.h"

namespace facet {

/// Copies what it is offered and returns: neither heap nor lock nor wait. Buffers: 128 frames, four meshes, eight
/// calibrations; when full, the newest are dropped and counted. A mesh comes every kMeshPeriod at most, a calibration
/// every kCalibrationPeriod. Two threads: one offers, one passes on.
class EstimateQueue final : public FlightViewer {
public:
    static constexpr std::size_t kMeshes = 4;
    static constexpr Duration kMeshPeriod = Duration::from_seconds(0.5);
    static constexpr Duration kCalibrationPeriod = Duration::from_seconds(1.0);

    /// Heap: 1.4 MB.
    EstimateQueue();

    /// Pictures are in the log already.
    bool wants_picture(Timestamp, bool) const override { return false; }
    bool wants_calibration() const override { return newest_ >= next_calibration_; }
    void offer(const ViewState& state, const Fillers& fillers) override;

    /// Writes everything that waits.
    void pass_on(EstimateChannels& channels);

    /// Frames, meshes and calibrations. Thread-safe.
    std::uint64_t dropped() const { return dropped_.load(std::memory_order_relaxed); }

private:
    struct Mesh {
        Timestamp stamp;
        SlotLease slot;
    };
    struct Calibration {
        Timestamp stamp;
        CalibrationEstimate estimate;
    };
    void offer_mesh(Timestamp stamp, const Fillers& fillers);
    void count_dropped(Status pushed) { dropped_.fetch_add(ok(pushed) ? 0 : 1, std::memory_order_relaxed); }

    std::array<ViewMesh, kMeshes> pool_;
    SlotLender<kMeshes> slots_;
    SpscQueue<ViewState, 128> states_;
    SpscQueue<Mesh, kMeshes> meshes_;
    SpscQueue<Calibration, 8> calibrations_;
    std::atomic<std::uint64_t> dropped_{0};
    // Of the thread that offers:
    Timestamp newest_;
    Timestamp next_mesh_;
    Timestamp next_calibration_;
};

}  // namespace facet
