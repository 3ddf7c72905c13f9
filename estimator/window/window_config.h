// SPDX-License-Identifier: BSD-2-Clause
// Parameters of the fixed-lag window smoother.
#pragma once

#include "estimator/values/capacity.h"
#include "platform/base/parameter_field.h"
#include "platform/base/status.h"

namespace facet {

/// Units, ranges and meanings: kWindowFields below.
struct WindowConfig {
    /// Observations whose residual after optimization is larger than this are removed (px).
    static constexpr double kOutlierThreshold_px = 3.0;
    int keyframes = 20;
    int max_iterations = 4;
    double pixel_sigma_px = 0.5;
    bool spread_keyframes = true;
    bool published_weights = false;
    // Not among the parameters:
    bool learn_pixel_sigma = true;  ///< from residuals, beginning with pixel_sigma_px, within a factor of ten of it
    /// Of Cauchy's loss on observations, in multiples of the residuals' robust standard deviation: 1.2 is the
    /// likelihood of Student's t with two degrees of freedom, whose tails those of real tracks resemble.
    double loss_threshold = 1.2;

    /// kInvalidArgument if a field is outside its range.
    Status validate() const;
};

inline constexpr auto kWindowFields = std::to_array<ParameterField<WindowConfig>>({
    {FACET_FIELD(WindowConfig, keyframes), "-", 3, kMaxKeyframes, "Number of keyframes in the window."},
    {FACET_FIELD(WindowConfig, max_iterations), "-", 1, 50,
     "Largest number of solver steps at a keyframe; bounds the time it takes."},
    {FACET_FIELD(WindowConfig, pixel_sigma_px), "px", 0.1, 5,
     "Standard deviation of an observation in the image until it has been learned from residuals; measured: 0.15 px in "
     "rendered images, 0.4 px in real ones."},
    {FACET_FIELD(WindowConfig, spread_keyframes), "-", 0, 1,
     "Let a keyframe enter the window after the estimate of the frame that follows it, so that no frame takes the time "
     "of both; otherwise at once. Where anything is out of the ordinary, it is at once in any case."},
    {FACET_FIELD(WindowConfig, published_weights), "-", 0, 1,
     "Weigh images and planes by the constants of the program that the authors of the paper have published, in place "
     "of weights learned from residuals: for comparisons with the paper, not for flight."},
});

}  // namespace facet
