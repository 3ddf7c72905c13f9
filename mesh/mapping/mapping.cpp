// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/mapping/mapping.h"

#include <algorithm>
#include <limits>

#include "estimator/values/stage_scope.h"
#include "mesh/planes/plane_claim.h"
#include "platform/base/assert.h"

namespace facet {
namespace {

/// No stamp of a frame.
constexpr Timestamp kUnset{std::numeric_limits<std::int64_t>::min()};

}  // namespace

Mapping::Mapping() : mesher_(std::make_unique<Mesher>()), planes_(std::make_unique<PlaneFinder>()) {}

Status Mapping::configure(const MappingConfig& config, const StereoRig& rig) {
    FACET_TRY(estimator_.configure(config, rig));
    FACET_TRY(mesher_->configure(config.mesh, rig.left));
    FACET_TRY(planes_->configure(config.planes));
    FACET_TRY(config.grid.validate());
    FACET_TRY(config.map.validate());
    grid_.reset();
    if (config.grid.enabled) {
        grid_ = std::make_unique<OccupancyGrid>();
        FACET_ASSERT(ok(grid_->configure(config.grid)));  // validated above
    }
    depth_.reset();
    if (config.grid.enabled && config.grid.match_pixels && rig.has_right) {
        depth_ = std::make_unique<SemiDenseDepth>();
        FACET_ASSERT(ok(depth_->configure(rig)));  // images are large enough for the estimator
    }
    map_.reset();
    places_.reset();
    map_config_ = config.map;
    rig_ = rig;
    lost_after_s_ = config.health.lost_after_s;
    waiting_.configure(rig_);
    mapped_ = {};
    s_ = {};
    return Status::kOk;
}

void Mapping::set_stage_observer(StageObserver* observer) {
    observer_ = observer;
    estimator_.set_stage_observer(observer);
}

std::optional<KeptState> Mapping::keep() const {
    return is_usable(s_.health.state) ? std::optional(estimator_.keep()) : std::nullopt;
}

bool Mapping::take_carried(Estimate& estimate) {
    if (!ok(estimator_.take_carried(estimate))) {
        return false;
    }
    s_.health = estimate.health;
    s_.mesh_is_new = false;
    return true;
}

Status Mapping::add_frame(const StereoFrame& frame, Estimate& estimate) {
    estimate = {};
    estimate.stamp = kUnset;
    s_.status = estimator_.add_frame(frame, estimate);
    if (estimate.stamp == kUnset) {  // the estimator has said nothing
        estimate.stamp = frame.stamp;
        s_.refused_since = s_.refused_since.value_or(frame.stamp);
        describe_refusal(frame.stamp, s_.status, estimate.health);
    } else {
        s_.refused_since.reset();
        s_.health = estimate.health;
    }
    s_.accepted = ok(s_.status) ? frame.stamp : s_.accepted;
    s_.mesh_is_new = false;
    return s_.status;
}

void Mapping::describe_refusal(Timestamp stamp, Status status, Health& health) const {
    health = s_.health;
    health.is_keyframe = false;
    if (!is_usable(health.state)) {
        return;
    }
    health.reasons |= status == Status::kNotReady ? kReasonImuGap : kReasonImageRejected;
    // The clock may have gone back: then the time since the last good frame is negative.
    const Duration without = std::max(stamp - s_.accepted, stamp - s_.refused_since.value_or(stamp));
    const bool is_lost = without.seconds() > lost_after_s_;
    health.state = is_lost ? TrackingState::kLost : TrackingState::kDegraded;
    health.quality = is_lost ? 0 : health.quality;
}

bool Mapping::finish_frame(const StereoFrame& frame, const Estimate& estimate) {
    estimator_.finish_frame();
    s_.mesh_is_new = s_.status != Status::kNotReady && map_keyframe(frame, estimate);
    update_depth();
    update_map();
    update_places();
    return s_.mesh_is_new;
}

std::span<const DepartedFace> Mapping::departed() const {
    return s_.mesh_is_new ? mesher_->departed() : std::span<const DepartedFace>();
}

PlaneFit Mapping::claim_of(const TrackedPlane& plane) const {
    const KeyframeView& view = estimator_.keyframe_view();
    const StereoRig rig = view.is_exchanged ? rig_.exchanged() : rig_;
    const PlaneCovariance calibration = rig.has_right ? effect_of_calibration(plane.fit, rig, view.cameras, view.T_W_C0)
                                                      : PlaneCovariance(PlaneCovariance::Zero());
    return claimed_in_world(plane.fit, plane.from, calibration);
}

bool Mapping::map_keyframe(const StereoFrame& frame, const Estimate& estimate) {
    const std::uint32_t view = estimator_.keyframe_view().number;
    const bool is_new = view != s_.last_view;
    s_.last_view = view;
    const bool may_map = ok(s_.status) && estimate.health.is_keyframe && is_usable(estimate.health.state);
    const bool waits = estimator_.keyframe_waits();
    const bool is_present = is_new && may_map && !waits;
    const bool is_due = !is_new && s_.waiting_has_view;
    const MappedKeyframe present{frame, estimate.stamp, estimate.health.reset_counter};
    if (is_present || is_due) {
        update_mesh(is_present ? present : waiting_.get());
        waiting_.drop();
    }
    s_.waiting_has_view = is_new && waiting_.is_set();
    if (may_map && waits) {
        waiting_.keep(present);
    }
    return is_present || is_due;
}

void Mapping::update_mesh(const MappedKeyframe& keyframe) {
    mapped_ = keyframe;
    const KeyframeView& view = estimator_.keyframe_view();
    end_depth();
    {
        const StageScope scope(observer_, Stage::kMesh);
        mesher_->set_camera(view.is_exchanged ? rig_.right : rig_.left);
        mesher_->update(view, view.is_exchanged ? keyframe.frame.right : keyframe.frame.left);
        update_grid(view, keyframe.reset_counter);
    }
    update_planes(view, keyframe.reset_counter);
}

/// Before planes draw vertices to them: the grid has the surface as measured now and as it was shown before.
void Mapping::update_grid(const KeyframeView& view, std::uint32_t reset_counter) {
    if (!grid_ || !has_grid_reader_) {
        return;
    }
    if (reset_counter != s_.grid_reset_counter) {
        grid_->clear();
        s_.grid_reset_counter = reset_counter;
    }
    grid_->update(view, mesher_->mesh(), static_cast<std::uint32_t>(mesher_->counters().updates));
}

/// What has been matched of the last keyframe goes into the grid.
void Mapping::end_depth() {
    if (depth_ && depth_->has_begun()) {
        const StageScope scope(observer_, Stage::kDepth);
        grid_->add_depth(depth_->take());
    }
}

/// A keyframe with a mesh begins; each frame after it does a part. Its last part is the grid's.
void Mapping::update_depth() {
    if (!depth_ || !has_grid_reader_ || !(s_.mesh_is_new || depth_->has_begun())) {
        return;
    }
    if (!s_.mesh_is_new && !depth_->is_busy()) {
        end_depth();
        return;
    }
    const StageScope scope(observer_, Stage::kDepth);
    s_.mesh_is_new ? depth_->begin(estimator_.keyframe_view(), mapped_.frame.left, mapped_.frame.right)
                   : depth_->advance(*mesher_);
}

void Mapping::keep_map(SurfaceSink* sink) {
    if (!map_ && map_config_.enabled && rig_.has_right) {
        map_ = std::make_unique<SurfaceMap>();
        FACET_ASSERT(ok(map_->configure(map_config_, rig_)));  // the estimator has taken both
    }
    if (map_) {
        map_->give_to(sink);
    }
}

void Mapping::finish_map() {
    if (map_) {
        map_->finish();
    }
}

/// A keyframe with a mesh is taken; each frame after it does a part of the work.
void Mapping::update_map() {
    if (keyframe_sink_ != nullptr && s_.mesh_is_new) {
        const StageScope scope(observer_, Stage::kDepth);
        keyframe_sink_->take(estimator_.keyframe_view(), mapped_.reset_counter, mapped_.frame.left,
                             mapped_.frame.right);
    }
    if (!map_) {
        return;
    }
    const StageScope scope(observer_, Stage::kDepth);
    if (s_.mesh_is_new) {
        map_->add(estimator_.keyframe_view(), mapped_.reset_counter, mapped_.frame.left, mapped_.frame.right);
    } else {
        map_->advance();
    }
}

Status Mapping::remember_places(std::span<const MappedPlace> known) {
    auto memory = std::make_unique<PlaceMemory>();
    memory->configure(rig_);
    FACET_TRY(memory->load(known));
    places_ = std::move(memory);
    return Status::kOk;
}

void Mapping::finish_places() {
    if (places_) {
        places_->finish();
    }
}

/// A keyframe with a mesh is taken; it and each frame after it do a part of the work.
void Mapping::update_places() {
    if (!places_) {
        return;
    }
    const StageScope scope(observer_, Stage::kPlaces);
    if (s_.mesh_is_new) {
        places_->add(estimator_.keyframe_view(), mapped_.reset_counter, mapped_.frame.left);
    }
    places_->advance();
}

/// Planes are found in every mode; whether the estimator uses them is its mode's business.
void Mapping::update_planes(const KeyframeView& view, std::uint32_t reset_counter) {
    if (reset_counter != s_.planes_reset_counter) {
        planes_->reset();
        s_.planes_reset_counter = reset_counter;
    }
    const StageScope scope(observer_, Stage::kPlanes);
    const PlaneProposals& proposals = planes_->update(mesher_->mesh(), view);
    planes_->label(mesher_->mesh());
    planes_->flatten(mesher_->mesh());
    estimator_.set_planes(plane_source_ ? plane_source_(view, proposals) : proposals);
}

}  // namespace facet
