// SPDX-License-Identifier: BSD-2-Clause
// Estimator, mesher, plane finder and grid as one: the part that a replay and a live run share.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "app/calibration/calibration.h"
#include "app/config/program_config.h"
#include "app/output/frame_log.h"
#include "app/pipeline/meshed_keyframe.h"
#include "app/pipeline/obstacle_sweep.h"
#include "app/pipeline/stage_timer.h"
#include "estimator/api/estimator.h"
#include "mesh/depth/semi_dense_depth.h"
#include "mesh/mesher.h"
#include "mesh/occupancy_grid.h"
#include "mesh/planes/plane_finder.h"

namespace facet {

class FlightViewer;
class WorldServer;

/// What became of one frame, as values: it may be handed to another thread. About 10 KB.
struct FrameResult {
    Timestamp frame_stamp;   ///< as given to the estimator
    Timestamp output_stamp;  ///< under which timing and health are filed
    bool has_frame = true;   ///< false: the estimator's word on the time in which no frame has come
    Status status = Status::kOk;
    Estimate estimate;  ///< its state counts if `is_usable`
    bool is_keyframe = false;
    bool is_usable = false;      ///< there is an estimate to be used
    FrameTiming timing;          ///< of the frame and the inertial samples before it; so far, while it is not finished
    bool has_mesh = false;       ///< mesh and planes were brought up to date; the fields below count
    Timestamp mesh_frame_stamp;  ///< of the keyframe that they have taken in: this frame, or the one two frames before
    int mesh_vertices = 0;
    int mesh_faces = 0;
    MeshCounters mesh;
    FixedVector<TrackedPlane, kMaxPlanes> planes;             ///< planes, as the finder has them,
    FixedVector<PlaneFit, kMaxPlanes> claims;                 ///< and what is claimed of each: claimed_in_world()
    FixedVector<PlaneMerge, PlaneFinder::kMaxMerges> merges;  ///< ids found to be of one plane
    bool has_ranges = false;                                  ///< `ranges` were measured at this frame
    ObstacleRanges ranges;
};

/// Takes samples in order of time to the estimator, and keyframes to the mesher and the plane finder, whose planes go
/// back. Thread-bound. Heap in the constructor and in configure() only.
class FramePipeline {
public:
    FramePipeline();

    /// Throws InputError naming the parameters, or else the calibration, that cannot be used.
    void configure(const ProgramConfig& config, const Calibration& calibration);

    /// See Estimator.
    void set_observation_hook(ObservationHook* hook) { estimator_.set_observation_hook(hook); }

    /// The planes that the estimator is given for those found at a keyframe.
    using PlaneSource = std::function<const PlaneProposals&(const KeyframeView& view, const PlaneProposals& found)>;
    /// For studies; without one it is given what was found.
    void set_plane_source(PlaneSource source) { plane_source_ = std::move(source); }

    /// Distances to obstacles from now on, in FrameResult::ranges. Heap.
    void measure_ranges(const ObstacleOptions& options, const Se3& T_body_imu = {}) {
        obstacles_.emplace(options, T_body_imu);
        keep_grid();
    }

    /// Mesh, planes and grid from now on after each keyframe that brings a mesh. Borrowed; nullptr: to nobody.
    void stream_to(WorldServer* world) {
        world_ = world;
        if (world != nullptr) {
            keep_grid();
        }
    }

    /// Fills the grid, and measures depth for it, from the next keyframe on. Without somebody who reads it, it costs
    /// nothing: those who call measure_ranges() and stream_to() need not ask, those who read grid() do.
    void keep_grid() { has_grid_reader_ = true; }

    /// Every frame from now on, to this viewer as well. Borrowed; nullptr: to nobody more. Heap.
    void show_to(FlightViewer* viewer) {
        if (viewer != nullptr) {
            viewers_.push_back(viewer);
        }
    }

    /// See Estimator.
    void request_reset() { estimator_.request_reset(); }

    /// See Estimator; none while the estimate is not to be used.
    std::optional<KeptState> keep() const;
    Status resume(const KeptState& kept, double elapsed_s) { return estimator_.resume(kept, elapsed_s); }

    /// @param sample  as read: it is corrected by the calibration's model of the IMU
    void add_imu(const ImuSample& sample);
    const ImuModel& imu_model() const { return imu_model_; }
    /// What the estimator says while frames do not come; ask after each inertial sample. @return whether it said
    /// anything (result untouched otherwise)
    bool take_carried(FrameResult& result);
    /// A refused frame is never TRACKING: DEGRADED at first, LOST once no frame has been accepted for the time that the
    /// configuration allows without vision. The estimate's stamp is brought from the frame's stamp to the output's.
    /// @param output_stamp  differs from the frame's if the frame's clock was tampered with
    /// @param result        status kNotReady: inertial samples do not reach the frame yet; without mesh, planes, ranges
    ///                      and timing, which finish_frame() adds
    void estimate_frame(const StereoFrame& frame, Timestamp output_stamp, FrameResult& result);
    /// What no estimate waits for: a keyframe's surface points, its turn in the window, and its mesh, grid and planes,
    /// at once or at the two frames after it (Estimator::keyframe_waits()); ranges, and all viewers. To be called after
    /// each estimate_frame(), with the same frame and result, unless the frame is offered again. If the next frame is
    /// there by then, it waits: the planes found here count from the next keyframe on.
    void finish_frame(const StereoFrame& frame, FrameResult& result);
    /// Both.
    void add_frame(const StereoFrame& frame, Timestamp output_stamp, FrameResult& result);

    /// The last frame was finished too late for whoever waits for it; see Estimator.
    void report_overrun() { estimator_.report_overrun(); }

    /// The keyframe of the newest mesh. Its images are valid until the next finish_frame().
    const MeshedKeyframe& meshed() const { return meshed_; }

    /// Faces that left the horizon at the last frame; empty if that had no mesh.
    std::span<const DepartedFace> departed() const;

    /// See Estimator.
    const KeyframeView& keyframe_view() const { return estimator_.keyframe_view(); }
    const Mesher& mesher() const { return *mesher_; }
    const PlaneFinder& planes() const { return *planes_; }
    /// Free, occupied and unknown space, all unknown before keep_grid(); null if the configuration has no grid.
    const OccupancyGrid* grid() const { return grid_.get(); }
    /// Semi-dense depth; null if the configuration has none.
    const SemiDenseDepth* depth() const { return depth_.get(); }
    /// The cameras as given.
    const StereoRig& rig() const { return rig_; }
    CalibrationEstimate calibration() const { return estimator_.calibration(); }
    const VisionResiduals& residuals() const { return estimator_.residuals(); }
    /// See Estimator.
    const Belief& belief() const { return estimator_.belief(); }
    std::size_t imu_samples() const { return imu_samples_; }
    std::size_t imu_refused() const { return imu_refused_; }

private:
    void describe_refusal(Timestamp stamp, Status status, Health& health) const;
    PlaneFit claim_of(const TrackedPlane& plane) const;
    void update_ranges(FrameResult& result);
    void stream_world(const FrameResult& result);
    /// Brings the mesh up to date if it is time for a keyframe, the present or an earlier one. @return whether it was
    bool mesh_keyframe(const StereoFrame& frame, const FrameResult& result);
    void update_mesh(const MeshedKeyframe& keyframe);
    void end_depth();
    void update_depth();
    void update_planes(const KeyframeView& view, std::uint32_t reset_counter);
    void update_grid(const KeyframeView& view, std::uint32_t reset_counter);

    StereoRig rig_;
    ImuModel imu_model_;
    ImuLimits imu_limits_;
    Estimator estimator_;
    std::unique_ptr<Mesher> mesher_;
    std::unique_ptr<PlaneFinder> planes_;
    std::unique_ptr<OccupancyGrid> grid_;    ///< none unless enabled
    std::unique_ptr<SemiDenseDepth> depth_;  ///< none unless enabled, and a grid
    PlaneSource plane_source_;
    std::optional<ObstacleSweep> obstacles_;
    WorldServer* world_ = nullptr;
    std::vector<FlightViewer*> viewers_;
    std::uint32_t planes_reset_counter_ = 0;  ///< the estimator's when the planes were last looked for
    std::uint32_t grid_reset_counter_ = 0;    ///< and when the grid was last filled
    std::uint32_t last_view_ = 0;
    KeptKeyframe waiting_;           ///< a keyframe whose mesh is still to be made
    bool waiting_has_view_ = false;  ///< it is last_view_
    MeshedKeyframe meshed_;
    Health last_health_;                      ///< of the newest estimate
    Timestamp last_accepted_;                 ///< stamp of its frame, as given
    std::optional<Timestamp> refused_since_;  ///< stamp of the first frame after it
    Duration shift_;                          ///< of output stamps against the frames'
    double lost_after_s_ = 0.0;
    bool mesh_is_new_ = false;
    bool has_grid_reader_ = false;
    StageTimer timer_;
    std::size_t imu_samples_ = 0;
    std::size_t imu_refused_ = 0;
};

/// Whether the estimate is to be used.
constexpr bool is_usable(TrackingState state) {
    return state == TrackingState::kTracking || state == TrackingState::kDegraded;
}

}  // namespace facet
