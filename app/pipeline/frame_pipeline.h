// SPDX-License-Identifier: BSD-2-Clause
// The mapping as a program runs it, timed, measured and shown: the part that a replay and a live run share.
#pragma once

#include <optional>
#include <span>
#include <utility>

#include "app/calibration/calibration.h"
#include "app/config/program_config.h"
#include "app/output/frame_log.h"
#include "app/pipeline/obstacle_sweep.h"
#include "app/pipeline/stage_timer.h"
#include "mesh/mapping/mapping.h"

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
    bool is_usable = false;        ///< there is an estimate to be used
    std::optional<YawPose> T_M_W;  ///< from W to the map of places, while the pose in it is known
    FrameTiming timing;          ///< of the frame and the inertial samples before it; so far, while it is not finished
    bool has_mesh = false;       ///< mesh and planes were brought up to date; the fields below count
    Timestamp mesh_frame_stamp;  ///< of the keyframe that they have taken in: this frame, or the one two frames before
    int mesh_vertices = 0;
    int mesh_faces = 0;
    MeshCounters mesh;
    FixedVector<TrackedPlane, kMaxPlanes> planes;             ///< planes, as the finder has them,
    FixedVector<PlaneFit, kMaxPlanes> claims;                 ///< and the sigmas of each: claimed_in_world()
    FixedVector<PlaneMerge, PlaneFinder::kMaxMerges> merges;  ///< ids found to be of one plane
    bool has_ranges = false;                                  ///< `ranges` were measured at this frame
    ObstacleRanges ranges;
};

/// A Mapping with parameters of files, corrected samples, times, distances to obstacles, and those who are shown or
/// sent the results. Thread-bound. Heap in the constructor and in configure() only.
class FramePipeline {
public:
    /// Throws InputError naming the parameters, or else the calibration, that cannot be used.
    void configure(const ProgramConfig& config, const Calibration& calibration);

    /// See Mapping.
    void set_observation_hook(ObservationHook* hook) { mapping_.set_observation_hook(hook); }
    void set_plane_source(Mapping::PlaneSource source) { mapping_.set_plane_source(std::move(source)); }

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

    /// See Mapping. Those who call measure_ranges() and stream_to() need not ask, those who read grid() do.
    void keep_grid() { mapping_.keep_grid(); }

    /// See Mapping.
    void keep_map(SurfaceSink* sink) { mapping_.keep_map(sink); }
    void finish_map() { mapping_.finish_map(); }
    void give_keyframes_to(KeyframeSink* sink) { mapping_.give_keyframes_to(sink); }

    /// See Mapping. Throws InputError if the map has too many places.
    void remember_places(std::span<const MappedPlace> known);
    void finish_places() { mapping_.finish_places(); }

    /// Every frame from now on, to this viewer as well. Borrowed; nullptr: to nobody more. Heap.
    void show_to(FlightViewer* viewer) {
        if (viewer != nullptr) {
            viewers_.push_back(viewer);
        }
    }

    /// See Mapping.
    void request_reset() { mapping_.request_reset(); }
    std::optional<KeptState> keep() const { return mapping_.keep(); }
    Status resume(const KeptState& kept, double elapsed_s) { return mapping_.resume(kept, elapsed_s); }

    /// @param sample  as read: it is corrected by the calibration's model of the IMU
    void add_imu(const ImuSample& sample);
    /// See Mapping.
    void add_range(const RangeSample& sample);
    const ImuModel& imu_model() const { return imu_model_; }
    /// What the estimator says while frames do not come; ask after each inertial sample. @return whether it said
    /// anything (result untouched otherwise)
    bool take_carried(FrameResult& result);
    /// See Mapping::add_frame. The estimate's stamp is brought from the frame's stamp to the output's.
    /// @param output_stamp  differs from the frame's if the frame's clock was tampered with
    /// @param result        status kNotReady: inertial samples do not reach the frame yet; without mesh, planes, ranges
    ///                      and timing, which finish_frame() adds
    void estimate_frame(const StereoFrame& frame, Timestamp output_stamp, FrameResult& result);
    /// See Mapping::finish_frame; then ranges, and all viewers. With the same frame and result, unless the frame is
    /// offered again. If the next frame is there by then, it waits: the planes found here count from the next keyframe
    /// on.
    void finish_frame(const StereoFrame& frame, FrameResult& result);
    /// Both.
    void add_frame(const StereoFrame& frame, Timestamp output_stamp, FrameResult& result);

    /// The last frame was finished too late for whoever waits for it; see Estimator.
    void report_overrun() { mapping_.report_overrun(); }

    /// See Mapping.
    const MappedKeyframe& mapped() const { return mapping_.keyframe(); }
    std::span<const DepartedFace> departed() const { return mapping_.departed(); }
    const KeyframeView& keyframe_view() const { return mapping_.keyframe_view(); }
    const Mesher& mesher() const { return mapping_.mesher(); }
    const PlaneFinder& planes() const { return mapping_.planes(); }
    const OccupancyGrid* grid() const { return mapping_.grid(); }
    const SemiDenseDepth* depth() const { return mapping_.depth(); }
    const SurfaceMap* map() const { return mapping_.map(); }
    const PlaceMemory* places() const { return mapping_.places(); }
    const StereoRig& rig() const { return mapping_.rig(); }
    CalibrationEstimate calibration() const { return mapping_.estimator().calibration(); }
    const VisionResiduals& residuals() const { return mapping_.estimator().residuals(); }
    const Belief& belief() const { return mapping_.estimator().belief(); }
    std::size_t imu_samples() const { return imu_samples_; }
    std::size_t imu_refused() const { return imu_refused_; }
    std::size_t range_samples() const { return range_samples_; }
    std::size_t range_refused() const { return range_refused_; }

private:
    std::optional<YawPose> map_from_world() const;
    void update_ranges(FrameResult& result);
    void stream_world(const FrameResult& result);

    ImuModel imu_model_;
    ImuLimits imu_limits_;
    Mapping mapping_;
    std::optional<ObstacleSweep> obstacles_;
    WorldServer* world_ = nullptr;
    std::vector<FlightViewer*> viewers_;
    Duration shift_;  ///< of output stamps against the frames'
    StageTimer timer_;
    std::size_t imu_samples_ = 0;
    std::size_t imu_refused_ = 0;
    std::size_t range_samples_ = 0;
    std::size_t range_refused_ = 0;
};

}  // namespace facet
