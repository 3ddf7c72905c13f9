// SPDX-License-Identifier: BSD-2-Clause
// How the program of the paper's authors weighs images and planes, for comparisons with the paper.
#pragma once

#include "estimator/geometry/robust_loss.h"
#include "estimator/window/regularity_config.h"
#include "estimator/window/window_config.h"

namespace facet {

/// Constants of the program that the authors of [Rosinol19] published (Kimera-VIO, commit 31724f95,
/// params/Euroc/regularVioParameters.yaml). They hold where WindowConfig::published_weights is set.
///   Mode s: structureless factors, equal weights, no robust loss. Modes sp and spr: landmarks that the mesh sees on a
/// plane have projection factors, narrower and with Tukey's loss. Mode spr: regularity factors, of which each counts as
/// if it were independent. Structureless or not, landmarks are eliminated here, which is the same step to rounding.
struct PublishedWeights {
    static constexpr double kStructureless_px = 3.0;
    static constexpr double kProjection_px = 1.8;
    static constexpr double kProjectionTukey = 4.6851;
    static constexpr double kRegularity_m = 0.03;
    static constexpr double kRegularityHuber = 0.04;

    /// Of observations of landmarks on planes, whitened by kStructureless_px.
    static constexpr RobustLoss projection_loss() {
        constexpr double kRatio = kStructureless_px / kProjection_px;
        return {kProjectionTukey, LossKind::kTukey, kRatio * kRatio};
    }

    /// The regularities of a window with this configuration.
    static RegularityConfig of_regularities(const WindowConfig& window, RegularityConfig config) {
        if (window.published_weights) {
            config.sigma_m = kRegularity_m;
            config.huber_threshold = kRegularityHuber;
            config.height_correlation = 0.0;
        }
        return config;
    }
};

}  // namespace facet
