// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/tracker.h"

#include <Eigen/LU>
#include <algorithm>

#include "estimator/api/capacity.h"

namespace facet {
namespace {

constexpr int kTemplates = kMaxFeatures + kMaxDormantTracks;
/// A lost track must look more like its template than one followed from frame to frame: nothing else vouches for it.
constexpr float kRecallCorrelation = 0.88F;

}  // namespace

Status Tracker::configure(const FrontendConfig& config, const CameraModel& camera) {
    config_ = config;
    camera_ = camera;
    FACET_TRY(aligner_.configure(config.window_px, config.pyramid_levels, config.lk_iterations, config.lk_epsilon_px));
    templates_.resize(kTemplates);
    for (PatchTemplate& patch : templates_) {
        aligner_.allocate(patch);
    }
    aligner_.allocate(probe_);
    free_.reserve(kTemplates);
    reset();
    return Status::kOk;
}

void Tracker::reset() {
    free_.clear();
    for (int slot = kTemplates - 1; slot >= 0; --slot) {
        free_.push_back(slot);
    }
}

Status Tracker::start(const ImagePyramid& image, const Eigen::Vector2d& uv, Track& track) {
    if (free_.empty()) {
        return Status::kFull;
    }
    const int slot = free_.back();
    Eigen::Vector2d xy;
    FACET_TRY(camera_.unproject(uv, xy));
    FACET_TRY(
        aligner_.extract(image, uv, {config_.pyramid_levels - 1, true}, templates_[static_cast<std::size_t>(slot)]));
    free_.pop_back();
    track = Track{};
    track.slot = slot;
    track.pose.uv = uv;
    track.xy = xy;
    return Status::kOk;
}

Status Tracker::follow(const ImagePyramid& previous, const ImagePyramid& present, const FrameMotion& motion,
                       Track& track) {
    // Prediction: rotate the bearing, add the velocity; warp: the derivative of that map, through both distortions.
    Eigen::Matrix2d d_xy_d_uv;
    Eigen::Vector2d xy_previous;
    FACET_TRY(camera_.unproject(track.pose.uv, xy_previous, &d_xy_d_uv));
    const Eigen::Matrix3d R = motion.q_C_Cp.toRotationMatrix();
    const Eigen::Vector3d rotated = R * xy_previous.homogeneous();
    if (!(rotated.z() > 0.1)) {
        return Status::kNotFound;
    }
    const Eigen::Vector2d rotated_xy = rotated.hnormalized();
    const Eigen::Vector2d predicted_xy = rotated_xy + motion.dt_s * track.velocity;
    Eigen::Vector2d predicted_uv;
    Eigen::Matrix<double, 2, 3> d_uv_d_p;
    if (!ok(camera_.project(predicted_xy.homogeneous(), predicted_uv, &d_uv_d_p))) {
        return Status::kNotFound;
    }
    Eigen::Matrix<double, 2, 3> d_xy_d_rotated;
    d_xy_d_rotated << 1.0, 0.0, -rotated_xy.x(), 0.0, 1.0, -rotated_xy.y();
    d_xy_d_rotated /= rotated.z();
    const Eigen::Matrix2f step = (d_uv_d_p.leftCols<2>() * d_xy_d_rotated * R.leftCols<2>() * d_xy_d_uv).cast<float>();

    PatchPose pose{step * track.pose.A, predicted_uv};
    float correlation = 0.0F;
    AlignOptions options;
    options.coarsest = config_.pyramid_levels - 1;
    options.affine = true;
    FACET_TRY(aligner_.align(patch(track), present, options, pose, correlation));
    Eigen::Vector2d xy;
    FACET_TRY(camera_.unproject(pose.uv, xy));

    // Backward: what is seen here must be found where the track was.
    FACET_TRY(aligner_.extract(present, pose.uv, {0, false}, probe_));
    PatchPose back{track.pose.A * pose.A.inverse(), track.pose.uv};
    float back_correlation = 0.0F;
    FACET_TRY(aligner_.align(probe_, previous, {.coarsest = 0}, back, back_correlation));
    if (!((back.uv - track.pose.uv).norm() < config_.forward_backward_px)) {
        return Status::kDegenerate;
    }
    track.velocity = (xy - rotated_xy) / motion.dt_s;
    track.has_velocity = true;
    track.pose = pose;
    track.xy = xy;
    ++track.age_frames;
    return Status::kOk;
}

Status Tracker::find_again(const ImagePyramid& image, const LandmarkPrediction& prediction,
                           const Eigen::Quaterniond& q_C_Cl, Track& track, Eigen::Vector2d& shift) const {
    Eigen::Matrix2d d_xy_d_uv;
    Eigen::Vector2d xy;
    FACET_TRY(camera_.unproject(track.pose.uv, xy, &d_xy_d_uv));
    const Eigen::Matrix3d R = q_C_Cl.toRotationMatrix();
    const Eigen::Vector3d rotated = R * xy.homogeneous();
    Eigen::Vector2d predicted_uv;
    Eigen::Matrix<double, 2, 3> d_uv_d_p;
    if (!(rotated.z() > 0.1) || !ok(camera_.project(prediction.left_xy.homogeneous(), predicted_uv, &d_uv_d_p)) ||
        !camera_.in_image(predicted_uv, border_px())) {
        return Status::kNotFound;
    }
    // The patch has turned with the camera and grown with the ratio of depths.
    Eigen::Matrix<double, 2, 3> d_xy_d_rotated;
    d_xy_d_rotated << 1.0, 0.0, -rotated.x() / rotated.z(), 0.0, 1.0, -rotated.y() / rotated.z();
    d_xy_d_rotated /= rotated.z();
    const double grown = track.has_depth && track.inverse_depth > 1e-3
                             ? std::clamp(prediction.inverse_depth / track.inverse_depth, 0.5, 2.0)
                             : 1.0;
    const Eigen::Matrix2f step =
        (grown * d_uv_d_p.leftCols<2>() * d_xy_d_rotated * R.leftCols<2>() * d_xy_d_uv).cast<float>();
    PatchPose pose{step * track.pose.A, predicted_uv};
    float correlation = 0.0F;
    AlignOptions options;
    options.coarsest = config_.pyramid_levels - 1;
    options.affine = true;
    options.min_correlation = kRecallCorrelation;
    FACET_TRY(aligner_.align(patch(track), image, options, pose, correlation));
    FACET_TRY(camera_.unproject(pose.uv, xy));
    shift = pose.uv - predicted_uv;
    track.pose = pose;
    track.xy = xy;
    track.has_velocity = false;
    return Status::kOk;
}

}  // namespace facet
