// SPDX-License-Identifier: BSD-2-Clause
#include "app/pipeline/frame_recorder.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstdio>
#include <utility>

#include "app/output/residual_log.h"
#include "app/support/console.h"

namespace facet {
namespace {

/// So many frames' times get their memory at the beginning: growing, they would be copied in flight, twice the memory
/// while that lasts.
constexpr std::size_t kFramesReserved = 20'000;

bool is_finite(const NavState& s) {
    return s.q_W_B.coeffs().allFinite() && s.p_W_B.allFinite() && s.v_W_B.allFinite() && s.bias.gyro.allFinite() &&
           s.bias.accel.allFinite();
}

}  // namespace

FrameRecorder::Files::Files(const std::string& folder)
    : lock(folder),
      warnings(folder),
      trajectory(folder),
      timing(folder),
      health(folder),
      mesh(folder),
      planes(folder) {}

FrameRecorder::FrameRecorder(std::string folder, const RecorderLimits& limits)
    : folder_(std::move(folder)), limits_(limits), run_mesh_(limits.mesh_faces), surface_(limits.map_faces) {
    summary_.timed.reserve(std::min(limits.timed_frames, kFramesReserved));
}

/// Of a run that never began the warnings may say why.
FrameRecorder::~FrameRecorder() {
    constexpr std::size_t kShown = 10;
    for (std::size_t i = 0; i < std::min(early_.size(), kShown); ++i) {
        print_err("warning: {}\n", early_[i].text);
    }
}

void FrameRecorder::open() {
    if (folder_.empty()) {
        return;
    }
    make_folder(folder_);
    files_.emplace(folder_);
    for (const EarlyWarning& warning : early_) {
        files_->warnings.add(warning.kind, warning.text);
    }
    early_.clear();
}

void FrameRecorder::open(std::string folder) {
    folder_ = std::move(folder);
    open();
}

void FrameRecorder::warn(const std::string& kind, const std::string& text) {
    if (files_) {
        files_->warnings.add(kind, text);
    } else if (!folder_.empty()) {
        early_.push_back({kind, text});
    } else {
        ++summary_.warnings[kind];
        print_err("warning: {}\n", text);
    }
}

void FrameRecorder::write(const FrameResult& frame, std::span<const DepartedFace> departed) {
    if (!frame.has_frame) {
        ++summary_.reports_without_frame;
        if (files_) {
            files_->health.write(frame.output_stamp, frame.estimate.health);
        }
        summary_.last.stamp = frame.estimate.stamp;
        summary_.last.health = frame.estimate.health;
        return;
    }
    ++summary_.frames;
    if (frame.has_mesh) {
        run_mesh_.collect(departed);
        summary_.mesh_faces_max = std::max(summary_.mesh_faces_max, frame.mesh_faces);
    }
    if (frame.status == Status::kNotReady) {
        ++summary_.frames_not_ready;
    } else if (!ok(frame.status)) {
        ++summary_.frames_refused;
        warn("refused_frame",
             fmt::format("frame {}: refused by the estimator: {}", frame.output_stamp.ns, to_string(frame.status)));
    }
    summary_.frames_before_estimate += summary_.estimates == 0 && !frame.is_usable ? 1 : 0;
    summary_.keyframes += frame.is_keyframe ? 1 : 0;
    ++summary_.frames_by_state[to_string(frame.estimate.health.state)];
    summary_.frames_contradicted += (frame.estimate.health.reasons & kReasonImuContradicted) != 0 ? 1 : 0;
    if ((frame.estimate.health.reasons & kReasonFixedPattern) != 0 && ++summary_.frames_fixed_pattern == 1) {
        const char* what =
            frame.estimate.health.fixed_share > 0.0
                ? "a part of the image moves with the vehicle (an emitter's dots, guards, legs, dirt on "
                  "a window) and is left out; a mask, or an emitter that is off, keeps it out from the start"
                : "every second frame shows the dots of an alternating emitter and is left out; switch "
                  "the emitter off";
        warn("fixed_pattern", fmt::format("frame {}: {}", frame.output_stamp.ns, what));
    }
    keep_timing(frame);
    if (files_) {
        if (frame.has_mesh) {
            files_->planes.write(frame.mesh_frame_stamp, frame.planes, frame.claims, frame.merges);
            files_->mesh.write(frame.mesh_frame_stamp, frame.mesh_vertices, frame.mesh_faces, frame.mesh);
        }
        files_->timing.write(frame.output_stamp, frame.is_keyframe, frame.timing);
        files_->health.write(frame.output_stamp, frame.estimate.health);
    }
    if (frame.is_usable) {
        keep(frame.estimate);
    } else {
        summary_.last.stamp = frame.estimate.stamp;
        summary_.last.health = frame.estimate.health;
    }
}

/// When full, the oldest makes room.
void FrameRecorder::keep_timing(const FrameResult& frame) {
    const RunSummary::TimedFrame timed{frame.is_keyframe, frame.timing};
    if (summary_.timed.size() < limits_.timed_frames) {
        summary_.timed.push_back(timed);
    } else if (limits_.timed_frames > 0) {
        summary_.timed[oldest_timed_] = timed;
        oldest_timed_ = (oldest_timed_ + 1) % limits_.timed_frames;
    }
}

void FrameRecorder::keep(const Estimate& estimate) {
    if (!is_finite(estimate.state)) {
        summary_.not_finite = true;
        warn("not_finite_estimate", fmt::format("frame {}: estimate is not finite; not written", estimate.stamp.ns));
        summary_.last.health = estimate.health;
        return;
    }
    if (files_ && !trajectory_at_samples_) {
        files_->trajectory.write(estimate);
    }
    if (summary_.estimates++ == 0) {
        summary_.first_estimate = estimate.stamp;
    } else {
        summary_.path_m += (estimate.state.p_W_B - summary_.last.state.p_W_B).norm();
    }
    summary_.last = estimate;
}

void FrameRecorder::write_carried(const Estimate& estimate) {
    if (files_ && trajectory_at_samples_ && is_finite(estimate.state)) {
        files_->trajectory.write(estimate);
    }
}

void FrameRecorder::flush() {
    if (files_) {
        files_->trajectory.flush();
        files_->timing.flush();
        files_->health.flush();
        files_->mesh.flush();
        files_->planes.flush();
        files_->warnings.flush();
    }
}

void FrameRecorder::finish(const FramePipeline& pipeline, const SurfaceMap* map) {
    if (map != nullptr) {
        summary_.map = map->counters();
        summary_.map_blocks = map->volume().block_count();
        summary_.map_blocks_left = map->volume().left();
    }
    summary_.imu_samples = pipeline.imu_samples();
    summary_.imu_refused = pipeline.imu_refused();
    if (pipeline.range_refused() > 0) {
        warn("range_finder", fmt::format("{} of {} readings were refused: not finite, or their stamps do not increase",
                                         pipeline.range_refused(), pipeline.range_samples()));
    }
    summary_.residuals = pipeline.residuals();
    summary_.rig = pipeline.rig();
    summary_.corrections = pipeline.calibration();
    summary_.mesh = pipeline.mesher().counters();
    summary_.planes = pipeline.planes().counters();
    summary_.mesh_vertices = pipeline.mesher().mesh().vertex_count();
    summary_.mesh_faces = pipeline.mesher().mesh().face_count();
    if (!files_) {
        summary_.run_mesh_faces = run_mesh_.faces();
        return;
    }
    if (surface_.dropped() > 0) {
        warn("map_left_out",
             fmt::format("mesh.ply is not all of the map: {} pieces of surface came when it had {} faces",
                         surface_.dropped(), surface_.triangles()));
    }
    summary_.warnings = files_->warnings.counts();
    std::remove((folder_ + "/summary.json").c_str());  // that of an earlier run, whose files are replaced now
    files_->trajectory.close();
    files_->timing.close();
    files_->health.close();
    files_->mesh.close();
    files_->planes.close();
    run_mesh_.write(pipeline.mesher(), folder_, files_->planes.names());
    if (surface_.triangles() > 0) {
        surface_.write(folder_ + "/mesh.ply", "facet: map, world frame of the estimate, metres",
                       SurfacePlanes(run_mesh_.all(), files_->planes.names()));
    } else {
        run_mesh_.write_all(folder_ + "/mesh.ply", files_->planes.names());
    }
    files_->planes.write_planes(folder_, run_mesh_.all());
    summary_.run_mesh_faces = run_mesh_.faces();
    files_->warnings.close();
    write_residuals(summary_.residuals, folder_);
    write_summary(summary_, folder_);
}

}  // namespace facet
