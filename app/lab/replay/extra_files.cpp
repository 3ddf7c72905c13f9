// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/replay/extra_files.h"

#include "app/lab/replay/grid_picture.h"
#include "app/output/map_file.h"

namespace facet {

ExtraFiles::ExtraFiles(const ReplayOptions& options, const StereoRig& given)
    : out_(options.out), map_(options.save_map) {
    if (options.write_rays) {
        rays_.emplace(out_);
        sweeps_.emplace(out_);
    }
    if (options.write_fused) {
        fusion_.emplace(given);
    }
    if (options.write_calibration) {
        corrections_.emplace(out_);
    }
    if (options.keep_places) {
        places_.emplace(out_);
    }
}

void ExtraFiles::write(const FrameResult& result, const FramePipeline& pipeline, const StereoFrame& frame) {
    if (rays_) {
        rays_->write(result, pipeline);
        sweeps_->write(result, pipeline);
    }
    if (fusion_ && result.is_usable) {
        fuse(result, pipeline, frame);
    }
    if (corrections_) {
        corrections_->write(result, pipeline);
    }
    if (places_) {
        places_->write(result.estimate, result.is_usable, *pipeline.places());
    }
}

void ExtraFiles::fuse(const FrameResult& result, const FramePipeline& pipeline, const StereoFrame& frame) {
    if (result.has_mesh) {
        const MappedKeyframe& keyframe = pipeline.mapped();
        fusion_->add(pipeline.keyframe_view(), keyframe.reset_counter, keyframe.frame.left, keyframe.frame.right,
                     pipeline.mesher());
    }
    if (!result.is_keyframe) {
        const std::uint32_t resets = result.estimate.health.reset_counter;
        const NavState& state = result.estimate.state;
        fusion_->add_between(Se3{state.q_W_B, state.p_W_B} * pipeline.rig().T_B_C0, resets, frame.left, frame.right);
    }
}

void ExtraFiles::finish(const FrameResult& last, const FramePipeline& pipeline) {
    if (rays_) {
        rays_->close();
        sweeps_->close();
        if (pipeline.grid() != nullptr) {
            write_grid_picture(*pipeline.grid(), last.estimate.state.p_W_B, out_ + "/grid.png");
        }
    }
    if (fusion_) {
        fusion_->write(out_ + "/mesh_fused.ply");
    }
    if (corrections_) {
        corrections_->close();
    }
    if (places_) {
        places_->close();
    }
    if (!map_.empty()) {
        write_map(map_, *pipeline.places());
    }
}

}  // namespace facet
