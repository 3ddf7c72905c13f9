// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/fusion/mesh_fusion.h"

#include <algorithm>
#include <cmath>

#include "app/output/run_surface.h"
#include "mesh/volume/partners.h"
#include "platform/base/assert.h"

namespace facet {
namespace {

constexpr int kSquare = 4;                 // px
constexpr std::ptrdiff_t kKeptAfter = 16;  // views that have left, as partners of the next ones
constexpr double kTypicalDepth = 2.5;      // m: what moves by it turns what is seen by a radian
constexpr double kNewView = 0.12;          // rad, of both: about a tenth of the image is new
constexpr double kResolvedStep = 0.5;      // m

/// Where a step of kResolvedStep is a pixel of disparity: farther away, stereo hardly knows a step from a slope.
TsdfOptions volume_options(double per_px) {
    TsdfOptions options;
    options.max_depth_m = std::sqrt(kResolvedStep / per_px);
    return options;
}

double median_depth(const std::vector<DepthSample>& samples) {
    std::vector<float> known;
    for (const DepthSample& s : samples) {
        if (s.inverse_depth > 0.0F) {
            known.push_back(s.inverse_depth);
        }
    }
    if (known.empty()) {
        return 0.0;
    }
    auto* const half = known.data() + known.size() / 2;
    std::nth_element(known.data(), half, known.data() + known.size());
    return 1.0 / static_cast<double>(*half);
}

}  // namespace

MeshFusion::MeshFusion(const StereoRig& rig)
    : sampler_(rig, kSquare),
      layout_{kSquare, sampler_.columns(), sampler_.rows(), sampler_.per_px()},
      raster_(rig.left, kSquare, sampler_.columns(), sampler_.rows()),
      bare_(raster_, layout_),
      volume_(volume_options(sampler_.per_px())) {
    FACET_ASSERT(ok(right_.configure(rig.right.intrinsics().width, rig.right.intrinsics().height, 1)));
}

void MeshFusion::add(const KeyframeView& view, std::uint32_t resets, const ImageView& left, const ImageView& right,
                     const Mesher& mesher) {
    for (std::size_t i = 0; i < views_.size(); ++i) {
        View& known = *views_[i];
        const auto* const pose = std::find_if(view.keyframes.begin(), view.keyframes.end(),
                                              [&](const KeyframePose& p) { return p.stamp == known.keyframe; });
        if (pose != view.keyframes.end() && known.resets == resets) {
            known.T_W_C0 = pose->T_W_C0 * known.T_K_C0;
        } else if (!known.has_left) {
            leave(i);
        }
    }
    auto gone = std::ranges::count_if(views_, [](const auto& v) { return v->has_left; });
    for (; gone > kKeptAfter && views_.front()->has_left; --gone) {
        views_.pop_front();
    }
    T_W_K_ = view.T_W_C0;
    View taken;
    taken.keyframe = view.stamp;
    taken.T_W_C0 = view.T_W_C0;
    taken.resets = resets;
    taken.cameras = view.cameras;
    has_K_ = !view.is_exchanged && !left.empty() && !right.empty();
    if (has_K_) {
        take(std::move(taken), left, right, &mesher);
    }
}

void MeshFusion::add_between(const Se3& T_W_C0, std::uint32_t resets, const ImageView& left, const ImageView& right) {
    if (!has_K_ || views_.back()->resets != resets || left.empty() || right.empty()) {
        return;
    }
    const View& last = *views_.back();
    const Se3 T_last_C = last.T_W_C0.inverse() * T_W_C0;
    if (so3_log(T_last_C.q).norm() + T_last_C.p.norm() / kTypicalDepth < kNewView) {
        return;
    }
    View taken;
    taken.keyframe = last.keyframe;
    taken.T_K_C0 = T_W_K_.inverse() * T_W_C0;
    taken.T_W_C0 = T_W_C0;
    taken.resets = resets;
    taken.cameras = last.cameras;
    take(std::move(taken), left, right, nullptr);
}

void MeshFusion::take(View view, const ImageView& left, const ImageView& right, const Mesher* mesher) {
    auto taken = std::make_unique<View>(std::move(view));
    FACET_ASSERT(ok(taken->left.configure(left.width, left.height, 1)));
    taken->left.build(left);
    right_.build(right);
    sampler_.correct(taken->cameras);
    for (int i = 0; i < layout_.count(); ++i) {
        taken->samples.push_back(sampler_.measure(i, taken->left, right_, mesher));
    }
    views_.push_back(std::move(taken));
}

void MeshFusion::compare(std::size_t index) {
    View& own = *views_[index];
    const double depth = median_depth(own.samples);
    for (const std::ptrdiff_t side : {-1, 1}) {
        std::vector<const View*> others;
        std::vector<Se3> T_own_others;
        const auto end = static_cast<std::ptrdiff_t>(views_.size());
        for (auto i = static_cast<std::ptrdiff_t>(index) + side; i >= 0 && i < end; i += side) {
            const View& other = *views_[static_cast<std::size_t>(i)];
            if (own.resets == other.resets) {
                others.push_back(&other);
                T_own_others.push_back(own.T_W_C0.inverse() * other.T_W_C0);
            }
        }
        for (const std::size_t i : choose_partners(T_own_others, depth)) {
            sampler_.face(T_own_others[i], own.cameras);
            for (DepthSample& sample : own.samples) {
                sampler_.compare(own.left, others[i]->left, sample);
            }
        }
    }
}

void MeshFusion::leave(std::size_t index) {
    View& view = *views_[index];
    view.has_left = true;
    compare(index);
    for (DepthSample& sample : view.samples) {
        if (sample.contradicted > sample.confirmed) {
            sample.inverse_depth = 0.0F;
        }
    }
    std::vector<SurfacePatch> patches;
    patches.reserve(static_cast<std::size_t>(layout_.count()));
    for (int i = 0; i < layout_.count(); ++i) {
        patches.push_back(fit_patch(view.samples, layout_, i));
    }
    bare_.begin(view.left.level(0), patches);
    while (bare_.advance(layout_.count())) {
    }
    volume_.integrate(raster_, patches, view.T_W_C0);
    view.samples.clear();
}

void MeshFusion::write(const std::string& path) {
    for (std::size_t i = 0; i < views_.size(); ++i) {
        if (!views_[i]->has_left) {
            leave(i);
        }
    }
    RunSurface surface;
    const auto nets = std::make_unique<SurfaceNets>();
    const auto piece = std::make_unique<SurfacePiece>();
    for (std::size_t slot = 0; slot < volume_.slot_end(); ++slot) {
        nets->extract(volume_, slot, *piece);
        surface.take(*piece, 0);
    }
    surface.write(path, "facet: fused, world frame of the estimate, metres");
}

}  // namespace facet
