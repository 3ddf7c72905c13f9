// SPDX-License-Identifier: BSD-2-Clause
#include "app/pipeline/live_picture.h"

#include <algorithm>
#include <iterator>

#include "app/pipeline/grid_slice.h"
#include "app/pipeline/scene_description.h"

namespace facet {
namespace {

std::int32_t plane_of(const LandmarkSnapshot& landmark) {
    return landmark.plane.valid() ? static_cast<std::int32_t>(landmark.plane.value) : -1;
}

/// The mean over a square of the image.
std::uint8_t mean_at(const ImageView& image, int u, int v, int side) {
    std::uint32_t sum = 0;
    for (int row = v; row < v + side; ++row) {
        for (int column = u; column < u + side; ++column) {
            sum += image.at(column, row);
        }
    }
    return static_cast<std::uint8_t>(sum / static_cast<std::uint32_t>(side * side));
}

/// What a picture is made of.
struct Scene {
    const ImageView& image;
    const KeyframeView* seen;  ///< null: no points
};

void draw(const Scene& scene, ViewPicture& picture) {
    const int side = shrink(scene.image, picture);
    if (scene.seen == nullptr) {
        return;
    }
    for (const LandmarkSnapshot& landmark : scene.seen->landmarks) {
        if (landmark.is_tracked && picture.points.size() < FlightViewer::kMaxPoints) {
            // Pixel (0, 0) has its centre at the origin, and so has each square.
            const Eigen::Vector2f px =
                (landmark.left_px.array() + 0.5F).matrix() / static_cast<float>(side) - Eigen::Vector2f::Constant(0.5F);
            picture.points.push_back({px, landmark.depth_m, plane_of(landmark)});
        }
    }
}

}  // namespace

int shrink(const ImageView& image, ViewPicture& picture) {
    constexpr int kMost = FlightViewer::kMaxPictureSide;
    const int side = std::max(1, (std::max(image.width, image.height) + kMost - 1) / kMost);
    picture.width = image.width / side;
    picture.height = image.height / side;
    picture.pixels.clear();
    for (int v = 0; v < picture.height; ++v) {
        for (int u = 0; u < picture.width; ++u) {
            picture.pixels.push_back(mean_at(image, side * u, side * v, side));
        }
    }
    return side;
}

void show_frame(const FrameResult& result, const StereoFrame& frame, const KeyframeView& seen,
                const FramePipeline& pipeline, FlightViewer& view) {
    const Estimate& estimate = result.estimate;
    FlightViewer::Fillers fillers;
    if (result.has_mesh) {
        fillers.mesh = [&](ViewMesh& mesh) {
            append_faces(pipeline.mesher(), mesh.faces);
            std::ranges::transform(result.planes, std::back_inserter(mesh.planes), to_scene);
        };
    }
    if (result.has_mesh) {
        fillers.landmarks = [&seen](std::vector<Eigen::Vector3f>& points) {
            for (const LandmarkSnapshot& landmark : seen.landmarks) {
                points.push_back(landmark.p_W.cast<float>());
            }
        };
    }
    if (result.has_mesh && pipeline.grid() != nullptr) {
        fillers.grid = [&](ViewGrid& slice) { slice_at(estimate.state.p_W_B, *pipeline.grid(), slice); };
    }
    const StereoFrame& shown = result.has_mesh ? pipeline.mapped().frame : frame;  // its points are known
    const bool takes_right = shown.left.empty() || (result.has_mesh && seen.is_exchanged);
    const Scene scene{takes_right ? shown.right : shown.left, result.has_mesh ? &seen : nullptr};
    if (!scene.image.empty() && view.wants_picture(estimate.stamp, result.has_mesh)) {
        fillers.picture = [&scene](ViewPicture& picture) { draw(scene, picture); };
    }
    if (result.is_keyframe && result.is_usable && view.wants_calibration()) {
        fillers.calibration = [&pipeline](CalibrationEstimate& calibration) { calibration = pipeline.calibration(); };
    }
    const StereoRig& rig = pipeline.rig();
    view.offer({.stamp = estimate.stamp,
                .has_pose = result.is_usable,
                .T_W_B = {estimate.state.q_W_B, estimate.state.p_W_B},
                .T_M_W = result.T_M_W ? std::optional(result.T_M_W->se3()) : std::nullopt,
                .T_B_C = estimate.T_B_Bc * (takes_right ? rig.T_B_C1 : rig.T_B_C0),
                .health = estimate.health,
                .is_keyframe = result.is_keyframe,
                .times = to_message_times(result.timing)},
               fillers);
}

}  // namespace facet
