// SPDX-License-Identifier: BSD-2-Clause
// Samples in; estimate, mesh, planes and free space out.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>

#include "estimator/api/estimator.h"
#include "mesh/depth/semi_dense_depth.h"
#include "mesh/mapping/keyframe_sink.h"
#include "mesh/mapping/mapped_keyframe.h"
#include "mesh/mapping/mapping_config.h"
#include "mesh/mesher.h"
#include "mesh/occupancy_grid.h"
#include "mesh/places/place_memory.h"
#include "mesh/planes/plane_finder.h"
#include "mesh/volume/surface_map.h"

namespace facet {

/// Estimator, mesher, plane finder and grid as one: keyframes go to the mesher with their own images, planes go back to
/// the estimator, exchanged cameras and restarts are followed. Usage:
///   Mapping mapping;
///   FACET_TRY(mapping.configure(config, rig));
///   mapping.add_imu(sample);                          // every sample, in order of time
///   if (mapping.take_carried(estimate)) { ... }       // what is said while frames do not come
///   mapping.add_frame(frame, estimate);               // every frame; kNotReady: offer it again after more samples
///   if (mapping.finish_frame(frame, estimate)) { ... mapping.mesher().mesh() ... }
/// Thread-bound. Deterministic. No clock, file, log or exception. Heap in the constructor, configure() and the setters.
class Mapping {
public:
    Mapping();

    /// Sets everything up; may be called again to start over.
    /// @return kInvalidArgument if a parameter or the rig is out of range (the object must not be used then)
    Status configure(const MappingConfig& config, const StereoRig& rig);

    /// See Estimator.
    Status set_masks(const ImageView& left, const ImageView& right) { return estimator_.set_masks(left, right); }
    void set_observation_hook(ObservationHook* hook) { estimator_.set_observation_hook(hook); }
    void request_reset() { estimator_.request_reset(); }
    void report_overrun() { estimator_.report_overrun(); }
    Status resume(const KeptState& kept, double elapsed_s) { return estimator_.resume(kept, elapsed_s); }
    /// Stages of estimator, mesh, planes and depth; nullptr to remove. Not owned.
    void set_stage_observer(StageObserver* observer);

    /// The planes that the estimator is given for those found at a keyframe.
    using PlaneSource = std::function<const PlaneProposals&(const KeyframeView& view, const PlaneProposals& found)>;
    /// For studies; without one it is given what was found.
    void set_plane_source(PlaneSource source) { plane_source_ = std::move(source); }

    /// Fills the grid, and measures depth for it, from the next keyframe on. Before, it costs nothing.
    void keep_grid() { has_grid_reader_ = true; }
    /// Fills the map from the next keyframe on and gives its surface to the sink, which is borrowed, a few pieces a
    /// frame; before, it costs nothing. Not if the configuration has no map, or the rig no right camera. To be called
    /// after configure(). Its work is timed as Stage::kDepth.
    void keep_map(SurfaceSink* sink);
    /// Instead of that: each keyframe with a mesh goes to the sink, such as one that keeps a map on another core.
    /// Borrowed; nullptr: to nobody. Timed as Stage::kDepth.
    void give_keyframes_to(KeyframeSink* sink) { keyframe_sink_ = sink; }
    /// All that the map has left to do, at once: at the end of a run.
    void finish_map();

    /// Remembers places from the next keyframe on, to know them again; before, it costs nothing. To be called after
    /// configure(). Its work is timed as Stage::kPlaces.
    /// @param known  a map of an earlier flight, in whose frame this one is then located; or empty
    /// @return kFull if these are more than kMaxPlaces
    Status remember_places(std::span<const MappedPlace> known);
    /// All that the memory has left to do, at once: at the end of a run.
    void finish_places();

    /// See Estimator::add_imu.
    Status add_imu(const ImuSample& sample, ImuAxisMask clipped) { return estimator_.add_imu(sample, clipped); }
    Status add_imu(const ImuSample& sample) { return estimator_.add_imu(sample); }
    /// See Estimator::add_range.
    Status add_range(const RangeSample& sample) { return estimator_.add_range(sample); }

    /// What the estimator says while frames do not come; ask after each sample. @return whether it said anything
    /// (estimate untouched otherwise)
    bool take_carried(Estimate& estimate);

    /// See Estimator::add_frame. The estimate is filled in any case: a frame that is refused is never TRACKING, but
    /// DEGRADED at first, LOST once no frame has been accepted for the time that the configuration allows without
    /// vision; its stamp is the frame's then.
    /// @return kNotReady if the samples do not reach the frame's stamp yet: offer it again later
    Status add_frame(const StereoFrame& frame, Estimate& estimate);

    /// What no estimate waits for: a keyframe's surface points, its turn in the window, and its mesh, grid and planes,
    /// at once or at the two frames after it. To be called after each add_frame(), with the same frame and estimate,
    /// unless the frame is offered again. @return whether mesh and planes are new: keyframe() says of when
    bool finish_frame(const StereoFrame& frame, const Estimate& estimate);

    /// The keyframe of the newest mesh. Its images are valid until the next finish_frame().
    const MappedKeyframe& keyframe() const { return mapped_; }
    /// Landmarks of the newest keyframe; see Estimator.
    const KeyframeView& keyframe_view() const { return estimator_.keyframe_view(); }
    const Mesher& mesher() const { return *mesher_; }
    /// Faces that left the horizon at the last frame; empty if that had no mesh.
    std::span<const DepartedFace> departed() const;
    const PlaneFinder& planes() const { return *planes_; }
    /// A plane as known in the world (claimed_in_world()), while the mesh is that of its keyframe.
    PlaneFit claim_of(const TrackedPlane& plane) const;
    /// Free, occupied and unknown space, all unknown before keep_grid(); null if the configuration has no grid.
    const OccupancyGrid* grid() const { return grid_.get(); }
    /// Semi-dense depth; null if the configuration has none.
    const SemiDenseDepth* depth() const { return depth_.get(); }

    /// The map of surfaces; null before keep_map().
    const SurfaceMap* map() const { return map_.get(); }

    /// The memory of places; null before remember_places().
    const PlaceMemory* places() const { return places_.get(); }

    /// The cameras as given.
    const StereoRig& rig() const { return rig_; }
    const Estimator& estimator() const { return estimator_; }
    /// What a program that restarts may go on from; none while the estimate is not to be used.
    std::optional<KeptState> keep() const;

private:
    /// What is remembered from frame to frame.
    struct State {
        std::uint32_t planes_reset_counter = 0;  ///< the estimator's when planes were last looked for
        std::uint32_t grid_reset_counter = 0;    ///< and when the grid was last filled
        std::uint32_t last_view = 0;
        bool waiting_has_view = false;  ///< the keyframe that waits is of last_view
        bool mesh_is_new = false;
        Status status = Status::kOk;             ///< of the newest frame
        Health health;                           ///< of the newest estimate
        Timestamp accepted;                      ///< stamp of its frame
        std::optional<Timestamp> refused_since;  ///< stamp of the first frame after it
    };

    void describe_refusal(Timestamp stamp, Status status, Health& health) const;
    /// Brings the mesh up to date if it is time for a keyframe, the present or an earlier one. @return whether it was
    bool map_keyframe(const StereoFrame& frame, const Estimate& estimate);
    void update_mesh(const MappedKeyframe& keyframe);
    void end_depth();
    void update_depth();
    void update_map();
    void update_places();
    void update_planes(const KeyframeView& view, std::uint32_t reset_counter);
    void update_grid(const KeyframeView& view, std::uint32_t reset_counter);

    StereoRig rig_;
    double lost_after_s_ = 0.0;
    Estimator estimator_;
    std::unique_ptr<Mesher> mesher_;
    std::unique_ptr<PlaneFinder> planes_;
    std::unique_ptr<OccupancyGrid> grid_;    ///< none unless enabled
    std::unique_ptr<SemiDenseDepth> depth_;  ///< none unless enabled, and a grid
    MapConfig map_config_;
    std::unique_ptr<SurfaceMap> map_;  ///< none before it is asked for
    KeyframeSink* keyframe_sink_ = nullptr;
    std::unique_ptr<PlaceMemory> places_;  ///< none before it is asked for
    PlaneSource plane_source_;
    StageObserver* observer_ = nullptr;
    bool has_grid_reader_ = false;
    KeptKeyframe waiting_;  ///< a keyframe whose mesh is still to be made
    MappedKeyframe mapped_;
    State s_;
};

/// Whether the estimate is to be used.
constexpr bool is_usable(TrackingState state) {
    return state == TrackingState::kTracking || state == TrackingState::kDegraded;
}

}  // namespace facet
