// SPDX-License-Identifier: BSD-2-Clause
// Parameters of the front-end.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "estimator/values/capacity.h"
#include "platform/base/parameter_field.h"
#include "platform/base/status.h"

namespace facet {

/// Whose code works on pixels; FrontendConfig::backend holds one of these as a number.
enum class FrontendBackend : std::uint8_t { kOwn, kOpenCv };
inline constexpr auto kFrontendBackends = std::to_array<std::string_view>({"own", "opencv"});

/// How corners are spread over the image.
struct CornerRules {
    double min_distance_px = 20.0;  ///< of a new corner from existing tracks; that of [Rosinol19]
    int columns = 12;               ///< of cells, of each of which the best corners are taken
    int rows = 8;
    double quality = 1e-3;  ///< least score of a corner as a share of the best score in the image
};

/// Units, ranges and meanings: kFrontendFields below.
struct FrontendConfig {
    /// Largest distance of a stereo match from an epipolar line that is known exactly; six sigmas of the line are added
    /// in quadrature (px).
    static constexpr double kStereoEpipolar_px = 1.5;
    /// Number of hypotheses of the outlier test; fixed, so that results and time are reproducible.
    static constexpr int kRansacIterations = 100;
    /// Largest number of alignment steps on each pyramid level of a track.
    static constexpr int kLkIterations = 20;
    /// Alignment of a track ends when a step is shorter than this (px).
    static constexpr double kLkEpsilon_px = 0.01;
    /// A keyframe is taken when a smaller share than this of the last keyframe's tracks is left.
    static constexpr double kKeyframeOverlap = 0.7;
    /// The images show standstill if the median disparity is below this (px).
    static constexpr double kStillDisparity_px = 0.5;
    /// Lost landmarks are searched for within this distance of their predicted position (px).
    static constexpr double kRecallRadius_px = 15.0;
    /// Least time between two keyframes, the paper's (s).
    static constexpr double kKeyframeMinInterval_s = 0.2;
    /// A track is dropped if tracking it forward and back again misses its start by more than this (px).
    static constexpr double kForwardBackward_px = 0.5;
    int backend = static_cast<int>(FrontendBackend::kOwn);
    int max_features = 300;
    int surface_points = 200;
    int pyramid_levels = 3;
    int window_px = 15;
    double min_depth_m = 0.3;
    std::uint32_t seed = 1;
    double keyframe_max_interval_s = 1.0;
    double keyframe_disparity_px = 8.0;
    CornerRules corners;  ///< not among the parameters

    bool uses_opencv() const { return backend == static_cast<int>(FrontendBackend::kOpenCv); }
    /// The condition between fields that does not hold, as a sentence; empty if all hold.
    std::string_view broken_rule() const;
    /// kInvalidArgument if a field is outside its range or a condition between fields does not hold.
    Status validate() const;
};

inline constexpr auto kFrontendFields = std::to_array<ParameterField<FrontendConfig>>({
    {FACET_FIELD(FrontendConfig, backend), "-", 0, 1,
     "Whose code works on pixels: 'own', or 'opencv' (features2d and video) where the build has it.",
     kFrontendBackends},
    {FACET_FIELD(FrontendConfig, max_features), "-", 20, kMaxFeatures,
     "Number of tracks requested in the left image; the default is the paper's."},
    {FACET_FIELD(FrontendConfig, surface_points), "-", 0, kMaxSurfacePoints,
     "Number of corners beyond the tracks that each keyframe matches in stereo for the mesh alone."},
    {FACET_FIELD(FrontendConfig, pyramid_levels), "-", 2, 6,
     "Number of image pyramid levels for tracking, full size included; prediction covers most of the motion, "
     "and 4 levels lose more tracks than 3."},
    {FACET_FIELD(FrontendConfig, window_px), "px", 7, 41,
     "Diameter of the tracked patch, an odd number; 21 px is 10 % more precise than 15 px at twice the time."},
    {FACET_FIELD(FrontendConfig, min_depth_m), "m", 0.05, 5, "Least depth of a stereo match."},
    {FACET_FIELD(FrontendConfig, seed), "-", 0, 4294967295.0, "Seed of the random hypotheses of the outlier test."},
    {FACET_FIELD(FrontendConfig, keyframe_max_interval_s), "s", 0.1, 5,
     "Largest time between two keyframes, also while standing still."},
    {FACET_FIELD(FrontendConfig, keyframe_disparity_px), "px", 0, 100,
     "A keyframe is taken when the median disparity to the last one, rotation removed, exceeds this."},
});

}  // namespace facet
