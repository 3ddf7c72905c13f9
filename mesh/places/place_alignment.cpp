// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/places/place_alignment.h"

#include <algorithm>
#include <array>
#include <optional>

#include "mesh/places/patch_search.h"
#include "mesh/places/sighting_fit.h"

namespace facet {
namespace {

/// What alignment across two views leaves (px), and what the point's own direction has.
constexpr double kAlignedSigma = 0.3;
/// A corner of the present view further than that from where the point was found shows another surface (px).
constexpr double kSameSurface = 2.0;
constexpr int kFitSteps = 6;
constexpr double kLeastShare = 0.5;

/// The point of the present view that matches each known one.
std::array<std::optional<std::size_t>, kMaxPlacePoints> seen_of_known(const PointMatches& matches) {
    std::array<std::optional<std::size_t>, kMaxPlacePoints> seen{};
    for (const PointMatch& match : matches) {
        seen[match.known] = match.seen;
    }
    return seen;
}

}  // namespace

Status align_place(const ImagePyramid& pyramid, const CameraModel& camera, const PlaceView& seen,
                   const PlaceView& known, const PointMatches& matches, PlacePose& pose) {
    const Eigen::Matrix3d R_C_G = seen.q_G_C.toRotationMatrix().transpose().cast<double>();
    const Eigen::Vector3d down_C = -R_C_G.col(2);
    const YawPose T_G_K = pose.T_K_G.inverse();
    const double pixel = 1.0 / camera.focal_px();
    std::array<std::optional<std::size_t>, kMaxPlacePoints> matched = seen_of_known(matches);
    SightingFit fit(seen, known, kAlignedSigma * pixel);
    int looked_for = 0;
    for (std::size_t i = 0; i < known.points.size(); ++i) {
        const PlacePoint& point = known.points[i];
        UprightSquare square;
        Eigen::Vector2d uv;
        Eigen::Vector2d xy;
        if (!ok(upright_square(camera, R_C_G * (T_G_K * point.p_G.cast<double>()), down_C, square)) ||
            !camera.in_image(square.centre, 0.0)) {
            continue;
        }
        ++looked_for;
        if (ok(search_patch(pyramid, square, point.code.octave, point.patch, uv)) && ok(camera.unproject(uv, xy))) {
            if (matched[i] && (fit.direction_of(*matched[i]) - xy).norm() > kSameSurface * pixel) {
                matched[i].reset();
            }
            fit.add(i, xy, matched[i]);
        }
    }
    SightingFit::State state{pose.T_K_G};
    SightingFit::Result result;
    for (int step = 0; step < kFitSteps; ++step) {
        result = fit.step(SightingFit::kAll, state);
    }
    if (result.inliers < kMinInliers || result.inliers < kLeastShare * static_cast<double>(fit.size())) {
        return Status::kDegenerate;
    }
    const double scale = std::max(1.0, result.chi2 / (result.measurements - 4.0));
    pose = {state.T_K_G, result.covariance * scale, looked_for, result.inliers};
    return Status::kOk;
}

}  // namespace facet
