// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/tracker.h"

#include <Eigen/LU>
#include <algorithm>

#include "estimator/values/capacity.h"

namespace facet {
namespace {

constexpr int kTemplates = kMaxFeatures + kMaxDormantTracks;
/// A lost track must match its template better than one followed from frame to frame: there is no other evidence.
constexpr float kRecallCorrelation = 0.88F;

}  // namespace

Status Tracker::configure(const FrontendConfig& config, const CameraModel& camera) {
    config_ = config;
    camera_ = camera;
    FACET_TRY(aligner_.configure(config.window_px, config.pyramid_levels, FrontendConfig::kLkIterations,
                                 FrontendConfig::kLkEpsilon_px));
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

Status Tracker::turn(const Eigen::Vector2d& xy, const Eigen::Quaterniond& q, TurnedPoint& point) const {
    // The bearing is known from the earlier frame: invert only the projection's derivative, not the distortion.
    Eigen::Vector2d uv;
    Eigen::Matrix<double, 2, 3> d_uv_d_p;
    FACET_TRY(camera_.project(xy.homogeneous(), uv, &d_uv_d_p));
    point.d_xy_d_uv = d_uv_d_p.leftCols<2>().inverse();
    point.R = q.toRotationMatrix();
    const Eigen::Vector3d rotated = point.R * xy.homogeneous();
    if (!(rotated.z() > 0.1)) {
        return Status::kNotFound;
    }
    point.xy = rotated.hnormalized();
    point.d_xy_d_rotated << 1.0, 0.0, -point.xy.x(), 0.0, 1.0, -point.xy.y();
    point.d_xy_d_rotated /= rotated.z();
    return Status::kOk;
}

Status Tracker::land(const TurnedPoint& point, const Eigen::Vector2d& xy, double grown, Eigen::Vector2d& uv,
                     Eigen::Matrix2f& map) const {
    Eigen::Matrix<double, 2, 3> d_uv_d_p;
    if (!ok(camera_.project(xy.homogeneous(), uv, &d_uv_d_p))) {
        return Status::kNotFound;
    }
    map =
        (grown * d_uv_d_p.leftCols<2>() * point.d_xy_d_rotated * point.R.leftCols<2>() * point.d_xy_d_uv).cast<float>();
    return Status::kOk;
}

Status Tracker::follow(const ImagePyramid& earlier, const ImagePyramid& present, const FrameMotion& motion,
                       Track& track) {
    // Prediction: rotate the bearing, add the velocity; warp: the derivative of that map, through both distortions.
    TurnedPoint turned;
    Eigen::Vector2d predicted_uv;
    Eigen::Matrix2f step;
    FACET_TRY(turn(track.xy, motion.q_C_Cp, turned));
    FACET_TRY(land(turned, turned.xy + motion.dt_s * track.velocity, 1.0, predicted_uv, step));

    PatchPose pose{step * track.pose.A, predicted_uv};
    float correlation = 0.0F;
    AlignOptions options;
    options.coarsest = config_.pyramid_levels - 1;
    options.affine = true;
    FACET_TRY(aligner_.align(patch(track), present, options, pose, correlation));
    if (!camera_.in_lens(pose.uv, border_px())) {
        return Status::kNotFound;
    }
    Eigen::Vector2d xy;
    FACET_TRY(camera_.unproject(pose.uv, xy));

    // Backward: what is seen here must be found where the track was.
    FACET_TRY(aligner_.extract(present, pose.uv, {0, false}, probe_));
    PatchPose back{track.pose.A * pose.A.inverse(), track.pose.uv};
    float back_correlation = 0.0F;
    const AlignOptions back_options{
        .coarsest = 0,
        .enough_px = PatchAligner::kCheckPrecision * static_cast<float>(FrontendConfig::kForwardBackward_px)};
    FACET_TRY(aligner_.align(probe_, earlier, back_options, back, back_correlation));
    if (!((back.uv - track.pose.uv).norm() < FrontendConfig::kForwardBackward_px)) {
        return Status::kDegenerate;
    }
    track.velocity = (xy - turned.xy) / motion.dt_s;
    track.has_velocity = true;
    track.pose = pose;
    track.xy = xy;
    ++track.age_frames;
    return Status::kOk;
}

Status Tracker::find_again(const ImagePyramid& image, const LandmarkPrediction& prediction,
                           const Eigen::Quaterniond& q_C_Cl, Track& track, Eigen::Vector2d& shift) const {
    // The patch has turned with the camera and grown with the ratio of depths.
    const double grown = track.has_depth && track.inverse_depth > 1e-3
                             ? std::clamp(prediction.inverse_depth / track.inverse_depth, 0.5, 2.0)
                             : 1.0;
    TurnedPoint turned;
    Eigen::Vector2d predicted_uv;
    Eigen::Matrix2f step;
    FACET_TRY(turn(track.xy, q_C_Cl, turned));
    FACET_TRY(land(turned, prediction.left_xy, grown, predicted_uv, step));
    if (!camera_.in_image(predicted_uv, border_px())) {
        return Status::kNotFound;
    }
    PatchPose pose{step * track.pose.A, predicted_uv};
    float correlation = 0.0F;
    AlignOptions options;
    options.coarsest = config_.pyramid_levels - 1;
    options.affine = true;
    options.min_correlation = kRecallCorrelation;
    FACET_TRY(aligner_.align(patch(track), image, options, pose, correlation));
    Eigen::Vector2d xy;
    FACET_TRY(camera_.unproject(pose.uv, xy));
    shift = pose.uv - predicted_uv;
    track.pose = pose;
    track.xy = xy;
    track.has_velocity = false;
    track.unseen = 0;
    return Status::kOk;
}

}  // namespace facet
