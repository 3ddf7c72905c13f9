// SPDX-License-Identifier: BSD-2-Clause
// Accuracy of an estimated trajectory: absolute and relative errors, and how much of the run it covers.
#pragma once

#include <span>
#include <vector>

#include "app/lab/eval/alignment.h"
#include "app/lab/eval/trajectory.h"
#include "app/lab/eval/truth_fit.h"

namespace facet {

/// A set of errors in figures; the median as OrderStatistics::median().
struct ErrorStatistics {
    std::size_t count = 0;
    double median = 0.0;
    double mean = 0.0;
    double rmse = 0.0;
    double max = 0.0;
};
ErrorStatistics error_statistics(std::vector<double> errors);

/// Absolute trajectory error after one alignment.
struct AbsoluteError {
    AlignmentMode mode = AlignmentMode::kSe3;
    Se3 T_true_est;                 ///< the alignment
    ErrorStatistics translation_m;  ///< |truth.p - T * estimate.p|
    ErrorStatistics rotation_deg;   ///< angle of truth.q^-1 * (T * estimate).q
};
AbsoluteError absolute_error(std::span<const PosePair> pairs, AlignmentMode mode);

/// Error over one stretch of the true path: (truth_i^-1 truth_j)^-1 (estimate_i^-1 estimate_j).
struct RelativeSample {
    Timestamp stamp;  ///< of pose i
    double stretch_m = 0.0;
    double translation_m = 0.0;
    double rotation_deg = 0.0;
    double yaw_deg = 0.0;  ///< error of the turn about the world's z; needs the 4-DoF alignment
    double translation_percent() const { return 100.0 * translation_m / stretch_m; }
};

/// Every pose starts a stretch, in the style of KITTI, which ends at the first pose at least `length_m` > 0 farther
/// along. In order of time. Heap. Reentrant.
std::vector<RelativeSample> relative_samples(std::span<const PosePair> pairs, double length_m);

/// The same in figures.
struct RelativeError {
    double length_m = 0.0;
    ErrorStatistics translation_m;
    ErrorStatistics translation_percent;  ///< of the stretch's true length
    ErrorStatistics rotation_deg;
    ErrorStatistics rotation_deg_per_m;
    ErrorStatistics yaw_deg;
};
RelativeError relative_error(std::span<const PosePair> pairs, double length_m);

/// What part of the run the estimate covers.
struct Coverage {
    double truth_span = 0.0;  ///< share of the ground truth's whole duration between first and last estimate
    double time = 0.0;  ///< same, of the part of the ground truth that has camera frames (= truth_span if unknown)
    bool has_frames = false;         ///< frame stamps are known
    std::size_t frames = 0;          ///< frames within the ground truth
    std::size_t frames_matched = 0;  ///< of these, with an estimate within 1/4 of the frame interval
    double frame_share() const {
        return frames == 0 ? 0.0 : static_cast<double>(frames_matched) / static_cast<double>(frames);
    }
};
/// @param frames  stamps of the left camera, sorted; empty if not known
Coverage coverage(const Trajectory& truth, const Trajectory& estimate, std::span<const Timestamp> frames);

struct EvaluationOptions {
    std::vector<double> rpe_lengths_m{1.0, 2.0, 5.0, 10.0};
    Duration max_truth_gap = Duration::from_seconds(0.5);  ///< longest hole in the ground truth to interpolate over
};

struct Evaluation {
    std::size_t truth_poses = 0;
    std::size_t estimate_poses = 0;
    std::size_t matched = 0;
    double path_m = 0.0;      ///< true path over the matched poses
    double duration_s = 0.0;  ///< from the first to the last matched pose
    AbsoluteError se3;
    AbsoluteError yaw4;
    double scale = 1.0;        ///< what SIM(3) would have chosen; not applied
    TruthFit truth_fit;        ///< what would fit best; not applied
    double end_drift_m = 0.0;  ///< position error of the last pose once the first poses are made equal
    double drift_percent() const { return path_m > 0.0 ? 100.0 * end_drift_m / path_m : 0.0; }
    std::vector<RelativeError> relative;
    Coverage coverage;
};

/// Evaluates an estimate. With no matched pose, all errors have count 0.
Evaluation evaluate(const Trajectory& truth, const Trajectory& estimate, std::span<const Timestamp> frames,
                    const EvaluationOptions& options);

}  // namespace facet
