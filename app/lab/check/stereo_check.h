// SPDX-License-Identifier: BSD-2-Clause
// Checks of the stereo pair: does the calibration explain where points are seen in both images?
#pragma once

#include <span>

#include "app/lab/check/free_matches.h"
#include "app/lab/check/verdict.h"
#include "estimator/geometry/stereo_rig.h"

namespace facet {

/// How far matches are from the epipolar geometry of a rig.
struct EpipolarFit {
    double median_px = 0.0;
    double q95_px = 0.0;
    double in_front = 0.0;  ///< share of the points that both cameras have in front of them
    std::size_t points = 0;
};

/// Signed distance of each pair by Sampson's approximation, in pixels of both images together [Hartley04] eq. (11.9):
///   e / |grad e|,   e = f1^T [t]x R f0,   f the undistorted points (x, y, 1), the gradient by the distorted pixels.
/// Pairs without a bearing are left out. Reentrant. Heap.
///
/// [Hartley04] Multiple View Geometry in Computer Vision, 2nd ed.
std::vector<double> epipolar_distances(const StereoRig& rig, std::span<const PointPair> pairs);
EpipolarFit fit_epipolar(const StereoRig& rig, std::span<const PointPair> pairs);

/// Median of the absolute distance expected with a good calibration: the matches' own 0.15 px, and what errors drawn
/// from CalibrationSigmas add on these points.
double expected_epipolar_px(const StereoRig& rig, std::span<const PointPair> pairs);

/// Two verdicts: "stereo epipolar error" (up to twice the expected one ok, up to six times suspicious), and "camera
/// order": whether another arrangement explains the pairs at least three times better, or puts points in front that the
/// given one has behind the cameras: images or calibrations exchanged, lenses exchanged, poses exchanged, poses
/// inverted. Cannot tell from fewer than 40 pairs.
std::vector<CheckVerdict> check_stereo(const StereoRig& rig, std::span<const PointPair> pairs);

/// Whether both cameras show one and the same image.
/// @param differences    mean_difference() of some stereo pairs
/// @param brightest_mean mean_grey() of the brightest of them: black images are alike whoever took them
CheckVerdict check_same_image(std::span<const double> differences, double brightest_mean);

}  // namespace facet
