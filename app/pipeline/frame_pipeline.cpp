// SPDX-License-Identifier: BSD-2-Clause
#include "app/pipeline/frame_pipeline.h"

#include <fmt/core.h>

#include <string>

#include "app/config/config_table.h"
#include "app/pipeline/live_picture.h"
#include "app/pipeline/mask_files.h"
#include "app/pipeline/world_description.h"
#include "app/support/input_error.h"
#include "drivers/world_stream/world_server.h"

namespace facet {
namespace {

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

void FramePipeline::configure(const ProgramConfig& config, const Calibration& calibration) {
    if (!ok(mapping_.configure(config, calibration.rig))) {
        throw InputError(refusal(config, calibration));
    }
    const CameraMasks masks = load_masks(calibration);
    FACET_ASSERT(ok(mapping_.set_masks(masks.left.view(), masks.right.view())));  // of their cameras' sizes
    mapping_.set_stage_observer(&timer_);
    imu_model_ = config.imu_model;
    imu_limits_ = config.imu_limits;
}

void FramePipeline::remember_places(std::span<const MappedPlace> known) {
    if (!ok(mapping_.remember_places(known))) {
        throw InputError(fmt::format("the map has {} places; at most {} can be used", known.size(), kMaxPlaces));
    }
}

void FramePipeline::add_imu(const ImuSample& sample) {
    const StageTimer::Instant begin = StageTimer::now();
    const Status status = mapping_.add_imu(imu_model_.corrected(sample), imu_limits_.clipped_axes(sample));
    timer_.add_total(begin);
    ++imu_samples_;
    imu_refused_ += ok(status) ? 0 : 1;
}

void FramePipeline::add_range(const RangeSample& sample) {
    const Status status = mapping_.add_range(sample);
    ++range_samples_;
    range_refused_ += ok(status) ? 0 : 1;
}

void FramePipeline::estimate_frame(const StereoFrame& frame, Timestamp output_stamp, FrameResult& result) {
    Estimate& estimate = result.estimate;
    const StageTimer::Instant begin = StageTimer::now();
    result.has_frame = true;
    result.status = mapping_.add_frame(frame, estimate);
    timer_.add_total(begin);
    shift_ = frame.stamp - output_stamp;
    estimate.stamp = estimate.stamp - shift_;
    result.frame_stamp = frame.stamp;
    result.output_stamp = output_stamp;
    result.is_keyframe = ok(result.status) && estimate.health.is_keyframe;
    result.is_usable = ok(result.status) && is_usable(estimate.health.state);
    result.T_M_W = map_from_world();
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
    result.has_mesh = mapping_.finish_frame(frame, result.estimate);
    timer_.add_total(begin);
    if (result.has_mesh) {
        result.mesh_frame_stamp = mapped().frame.stamp;
        result.mesh_vertices = mesher().mesh().vertex_count();
        result.mesh_faces = mesher().mesh().face_count();
        result.mesh = mesher().counters();
        for (const TrackedPlane& plane : planes().planes()) {
            if (plane.is_reported) {
                result.planes.push_back(plane);
                result.claims.push_back(mapping_.claim_of(plane));
            }
        }
        for (const PlaneMerge& merge : planes().merges()) {
            result.merges.push_back(merge);
        }
    }
    update_ranges(result);
    stream_world(result);
    result.timing = timer_.take();
    if (result.status != Status::kNotReady) {  // else the frame will be offered again
        for (FlightViewer* const viewer : viewers_) {
            show_frame(result, frame, keyframe_view(), *this, *viewer);
        }
    }
}

/// Part of the frame's time.
void FramePipeline::update_ranges(FrameResult& result) {
    if (!obstacles_) {
        return;
    }
    const StageTimer::Instant begin = StageTimer::now();
    if (result.has_mesh) {
        obstacles_->update(mesher().mesh());
    }
    result.has_ranges = result.is_usable && obstacles_->sweep(result.estimate, grid(), result.ranges);
    timer_.add_total(begin);
}

/// Part of the frame's time.
void FramePipeline::stream_world(const FrameResult& result) {
    if (world_ == nullptr || !result.has_mesh) {
        return;
    }
    const StageTimer::Instant begin = StageTimer::now();
    WorldState& world = world_->next();
    world.stamp_ns = mapped().estimate_stamp.ns;
    world.resets = mapped().reset_counter;
    describe_world(mesher().mesh(), {result.planes.data(), result.planes.size()}, grid(), world);
    world_->publish();
    timer_.add_total(begin);
}

std::optional<YawPose> FramePipeline::map_from_world() const {
    return places() != nullptr && places()->is_located() ? std::optional(places()->map_from_odom()) : std::nullopt;
}

bool FramePipeline::take_carried(FrameResult& result) {
    Estimate carried;
    if (!mapping_.take_carried(carried)) {
        return false;
    }
    result = {};
    result.has_frame = false;
    result.estimate = carried;
    result.estimate.stamp = carried.stamp - shift_;
    result.frame_stamp = carried.stamp;
    result.output_stamp = result.estimate.stamp;
    result.is_usable = is_usable(carried.health.state);
    result.T_M_W = map_from_world();
    return true;
}

}  // namespace facet
