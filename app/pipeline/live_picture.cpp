// SPDX-License-Identifier: BSD-2-Clause
#include "app/pipeline/live_picture.h"

#include <algorithm>

namespace facet {
namespace {

std::int32_t number_of(PlaneId plane) { return plane.valid() ? static_cast<std::int32_t>(plane.value) : -1; }

void append_faces(const Mesher& mesher, std::vector<ViewFace>& faces) {
    const HorizonMesh& mesh = mesher.mesh();
    for (int i = 0; i < mesh.face_end(); ++i) {
        if (mesh.is_face(i)) {
            const DepartedFace face = mesher.describe(mesh.face(static_cast<FaceIndex>(i)));
            faces.push_back({face.p_W, number_of(face.plane)});
        }
    }
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
        if (landmark.is_tracked && picture.points.size() < LiveView::kMaxPoints) {
            // Pixel (0, 0) has its centre at the origin, and so has each square.
            const Eigen::Vector2f px =
                (landmark.left_px.array() + 0.5F).matrix() / static_cast<float>(side) - Eigen::Vector2f::Constant(0.5F);
            picture.points.push_back({px, landmark.depth_m, number_of(landmark.plane)});
        }
    }
}

}  // namespace

int shrink(const ImageView& image, ViewPicture& picture) {
    constexpr int kMost = LiveView::kMaxPictureSide;
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

void show_frame(const FrameResult& result, const StereoFrame& frame, const KeyframeView& seen, const Mesher& mesher,
                LiveView& view) {
    const Estimate& estimate = result.estimate;
    LiveView::FillFaces fill;
    if (result.has_mesh) {
        fill = [&mesher](std::vector<ViewFace>& faces) { append_faces(mesher, faces); };
    }
    const bool takes_right = frame.left.empty() || (result.has_mesh && seen.is_exchanged);
    const Scene scene{takes_right ? frame.right : frame.left, result.has_mesh ? &seen : nullptr};
    LiveView::FillPicture fill_picture;
    if (!scene.image.empty() && view.wants_picture(estimate.stamp, result.has_mesh)) {
        fill_picture = [&scene](ViewPicture& picture) { draw(scene, picture); };
    }
    view.offer({.stamp = estimate.stamp,
                .has_pose = result.is_usable,
                .T_W_B = {estimate.state.q_W_B, estimate.state.p_W_B},
                .state = to_string(estimate.health.state),
                .quality = estimate.health.quality,
                .tracked = estimate.health.tracked,
                .total_ms = result.timing.total.wall_ms,
                .is_keyframe = result.is_keyframe},
               fill, fill_picture);
}

}  // namespace facet
