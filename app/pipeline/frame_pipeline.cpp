// SPDX-License-Identifier: BSD-2-Clause
#include "app/pipeline/frame_pipeline.h"

#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "app/config/config_table.h"
#include "app/pipeline/live_picture.h"
#include "app/pipeline/mask_files.h"
#include "app/pipeline/world_description.h"
#include "app/support/input_error.h"
#include "drivers/world_stream/world_server.h"
#include "mesh/planes/plane_claim.h"

namespace facet {
namespace {

/// No stamp of a frame.
constexpr Timestamp kUnset{std::numeric_limits<std::int64_t>::min()};

/// Why estimator, mesher and plane finder cannot be configured.
std::string refusal(const ProgramConfig& config, const Calibration& calibration) {
    if (std::string fault = describe_fault(config); !fault.empty()) {
        return fault;
    }
    const CameraIntrinsics& left = calibration.rig.left.intrinsics();
    return fmt::format(
        "calibration ({}): the estimator refuses these cameras; are {}x{} pixels too few for "
        "frontend.pyramid_levels {}?",
        calibration.source, left.width, left.height, config.frontend.pyramid_levels);
}

}  // namespace

FramePipeline::FramePipeline() : mesher_(std::make_unique<Mesher>()), planes_(std::make_unique<PlaneFinder>()) {}

void FramePipeline::configure(const ProgramConfig& config, const Calibration& calibration) {
    const bool is_configured = ok(estimator_.configure(config, calibration.rig)) &&
                               ok(mesher_->configure(config.mesh, calibration.rig.left)) &&
                               ok(planes_->configure(config.planes)) && ok(config.grid.validate()) &&
                               ok(config.depth.validate());
    if (!is_configured) {
        throw InputError(refusal(config, calibration));
    }
    const CameraMasks masks = load_masks(calibration);
    FACET_ASSERT(ok(estimator_.set_masks(masks.left.view(), masks.right.view())));  // of their cameras' sizes
    grid_.reset();
    if (config.grid.enabled) {
        grid_ = std::make_unique<OccupancyGrid>();
        FACET_ASSERT(ok(grid_->configure(config.grid)));  // validated above
    }
    depth_.reset();
    if (config.grid.enabled && config.depth.enabled && calibration.rig.has_right) {
        depth_ = std::make_unique<SemiDenseDepth>();
        FACET_ASSERT(ok(depth_->configure(config.depth, calibration.rig)));  // validated above
    }
    rig_ = calibration.rig;
    imu_model_ = config.imu_model;
    imu_limits_ = config.imu_limits;
    waiting_.configure(rig_);
    waiting_has_view_ = false;
    last_health_ = {};
    lost_after_s_ = config.health.lost_after_s;
    estimator_.set_stage_observer(&timer_);
}

std::optional<KeptState> FramePipeline::keep() const {
    return is_usable(last_health_.state) ? std::optional(estimator_.keep()) : std::nullopt;
}

void FramePipeline::add_imu(const ImuSample& sample) {
    const StageTimer::Instant begin = StageTimer::now();
    const Status status = estimator_.add_imu(imu_model_.corrected(sample), imu_limits_.clipped_axes(sample));
    timer_.add_total(begin);
    ++imu_samples_;
    imu_refused_ += ok(status) ? 0 : 1;
}

void FramePipeline::estimate_frame(const StereoFrame& frame, Timestamp output_stamp, FrameResult& result) {
    Estimate& estimate = result.estimate;
    estimate = {};
    estimate.stamp = kUnset;
    const StageTimer::Instant begin = StageTimer::now();
    result.has_frame = true;
    result.status = estimator_.add_frame(frame, estimate);
    timer_.add_total(begin);
    if (estimate.stamp == kUnset) {  // the estimator has said nothing
        estimate.stamp = frame.stamp;
        refused_since_ = refused_since_.value_or(frame.stamp);
        describe_refusal(frame.stamp, result.status, estimate.health);
    } else {
        refused_since_.reset();
        last_health_ = estimate.health;
    }
    last_accepted_ = ok(result.status) ? frame.stamp : last_accepted_;
    shift_ = frame.stamp - output_stamp;
    estimate.stamp = estimate.stamp - shift_;
    result.frame_stamp = frame.stamp;
    result.output_stamp = output_stamp;
    result.is_keyframe = ok(result.status) && estimate.health.is_keyframe;
    result.is_usable = ok(result.status) && is_usable(estimate.health.state);
    mesh_is_new_ = false;
    result.has_mesh = false;
    result.planes.clear();
    result.claims.clear();
    result.merges.clear();
    result.has_ranges = false;
    timer_.mark_estimate();
}

void FramePipeline::add_frame(const StereoFrame& frame, Timestamp output_stamp, FrameResult& result) {
    estimate_frame(frame, output_stamp, result);
    finish_frame(frame, result);
}

void FramePipeline::finish_frame(const StereoFrame& frame, FrameResult& result) {
    const StageTimer::Instant begin = StageTimer::now();
    estimator_.finish_frame();
    timer_.add_total(begin);
    mesh_is_new_ = result.status != Status::kNotReady && mesh_keyframe(frame, result);
    update_depth();
    result.has_mesh = mesh_is_new_;
    if (result.has_mesh) {
        result.mesh_frame_stamp = meshed_.frame.stamp;
        result.mesh_vertices = mesher_->mesh().vertex_count();
        result.mesh_faces = mesher_->mesh().face_count();
        result.mesh = mesher_->counters();
        for (const TrackedPlane& plane : planes_->planes()) {
            if (plane.is_reported) {
                result.planes.push_back(plane);
                result.claims.push_back(claim_of(plane));
            }
        }
        for (const PlaneMerge& merge : planes_->merges()) {
            result.merges.push_back(merge);
        }
    }
    update_ranges(result);
    stream_world(result);
    result.timing = timer_.take();
    if (result.status != Status::kNotReady) {  // else the frame will be offered again
        for (FlightViewer* const viewer : viewers_) {
            show_frame(result, frame, estimator_.keyframe_view(), *this, *viewer);
        }
    }
}

/// While the view is that of the keyframe at which the plane was found, or not found.
PlaneFit FramePipeline::claim_of(const TrackedPlane& plane) const {
    const KeyframeView& view = estimator_.keyframe_view();
    const StereoRig rig = view.is_exchanged ? rig_.exchanged() : rig_;
    const PlaneCovariance calibration = rig.has_right ? effect_of_calibration(plane.fit, rig, view.cameras, view.T_W_C0)
                                                      : PlaneCovariance(PlaneCovariance::Zero());
    return claimed_in_world(plane.fit, plane.from, calibration);
}

/// Part of the frame's time.
void FramePipeline::update_ranges(FrameResult& result) {
    if (!obstacles_) {
        return;
    }
    const StageTimer::Instant begin = StageTimer::now();
    if (mesh_is_new_) {
        obstacles_->update(mesher_->mesh());
    }
    result.has_ranges = result.is_usable && obstacles_->sweep(result.estimate, grid_.get(), result.ranges);
    timer_.add_total(begin);
}

/// Part of the frame's time.
void FramePipeline::stream_world(const FrameResult& result) {
    if (world_ == nullptr || !mesh_is_new_) {
        return;
    }
    const StageTimer::Instant begin = StageTimer::now();
    WorldState& world = world_->next();
    world.stamp_ns = meshed_.estimate_stamp.ns;
    world.resets = meshed_.reset_counter;
    describe_world(mesher_->mesh(), {result.planes.data(), result.planes.size()}, grid_.get(), world);
    world_->publish();
    timer_.add_total(begin);
}

void FramePipeline::describe_refusal(Timestamp stamp, Status status, Health& health) const {
    health = last_health_;
    health.is_keyframe = false;
    if (!is_usable(health.state)) {
        return;
    }
    health.reasons |= status == Status::kNotReady ? kReasonImuGap : kReasonImageRejected;
    // The clock may have gone back: then the time since the last good frame is negative.
    const Duration without = std::max(stamp - last_accepted_, stamp - refused_since_.value_or(stamp));
    const bool is_lost = without.seconds() > lost_after_s_;
    health.state = is_lost ? TrackingState::kLost : TrackingState::kDegraded;
    health.quality = is_lost ? 0 : health.quality;
}

bool FramePipeline::take_carried(FrameResult& result) {
    Estimate carried;
    if (!ok(estimator_.take_carried(carried))) {
        return false;
    }
    last_health_ = carried.health;
    result = {};
    result.has_frame = false;
    result.estimate = carried;
    result.estimate.stamp = carried.stamp - shift_;
    result.frame_stamp = carried.stamp;
    result.output_stamp = result.estimate.stamp;
    result.is_usable = is_usable(carried.health.state);
    mesh_is_new_ = false;
    return true;
}

std::span<const DepartedFace> FramePipeline::departed() const {
    return mesh_is_new_ ? mesher_->departed() : std::span<const DepartedFace>();
}

bool FramePipeline::mesh_keyframe(const StereoFrame& frame, const FrameResult& result) {
    const std::uint32_t view = estimator_.keyframe_view().number;
    const bool is_new = view != last_view_;
    last_view_ = view;
    const bool may_mesh = result.is_keyframe && result.is_usable;
    const bool waits = estimator_.keyframe_waits();
    const bool is_present = is_new && may_mesh && !waits;
    const bool is_due = !is_new && waiting_has_view_;
    const MeshedKeyframe present{frame, result.estimate.stamp, result.estimate.health.reset_counter};
    if (is_present || is_due) {
        update_mesh(is_present ? present : waiting_.get());
        waiting_.drop();
    }
    waiting_has_view_ = is_new && waiting_.is_set();
    if (may_mesh && waits) {
        waiting_.keep(present);
    }
    return is_present || is_due;
}

void FramePipeline::update_mesh(const MeshedKeyframe& keyframe) {
    meshed_ = keyframe;
    const KeyframeView& view = estimator_.keyframe_view();
    end_depth();
    const StageTimer::Instant begin = StageTimer::now();
    timer_.begin(Stage::kMesh);
    mesher_->set_camera(view.is_exchanged ? rig_.right : rig_.left);
    mesher_->update(view, view.is_exchanged ? keyframe.frame.right : keyframe.frame.left);
    update_grid(view, keyframe.reset_counter);
    timer_.end(Stage::kMesh);
    update_planes(view, keyframe.reset_counter);
    timer_.add_total(begin);
}

/// Before planes draw vertices to them: the grid has the surface as measured now and as it was shown before.
void FramePipeline::update_grid(const KeyframeView& view, std::uint32_t reset_counter) {
    if (!grid_ || !has_grid_reader_) {
        return;
    }
    if (reset_counter != grid_reset_counter_) {
        grid_->clear();
        grid_reset_counter_ = reset_counter;
    }
    grid_->update(view, mesher_->mesh(), static_cast<std::uint32_t>(mesher_->counters().updates));
}

/// What has been matched of the last keyframe goes into the grid.
void FramePipeline::end_depth() {
    if (depth_ && depth_->has_begun()) {
        const StageTimer::Instant begin = StageTimer::now();
        timer_.begin(Stage::kDepth);
        grid_->add_depth(depth_->take());
        timer_.end(Stage::kDepth);
        timer_.add_total(begin);
    }
}

/// A keyframe with a mesh begins; each frame after it does a part. Its last part is the grid's.
void FramePipeline::update_depth() {
    if (!depth_ || !has_grid_reader_ || !(mesh_is_new_ || depth_->has_begun())) {
        return;
    }
    if (!mesh_is_new_ && !depth_->is_busy()) {
        end_depth();
        return;
    }
    const StageTimer::Instant begin = StageTimer::now();
    timer_.begin(Stage::kDepth);
    mesh_is_new_ ? depth_->begin(estimator_.keyframe_view(), meshed_.frame.left, meshed_.frame.right)
                 : depth_->advance(*mesher_);
    timer_.end(Stage::kDepth);
    timer_.add_total(begin);
}

/// Planes are found in every mode; whether the estimator uses them is its mode's business.
void FramePipeline::update_planes(const KeyframeView& view, std::uint32_t reset_counter) {
    if (reset_counter != planes_reset_counter_) {
        planes_->reset();
        planes_reset_counter_ = reset_counter;
    }
    timer_.begin(Stage::kPlanes);
    const PlaneProposals& proposals = planes_->update(mesher_->mesh(), view);
    planes_->label(mesher_->mesh());
    planes_->flatten(mesher_->mesh());
    estimator_.set_planes(plane_source_ ? plane_source_(view, proposals) : proposals);
    timer_.end(Stage::kPlanes);
}

}  // namespace facet
