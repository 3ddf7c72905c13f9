// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/evaluation.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/lab/eval/pose_difference.h"
#include "app/support/statistics.h"

namespace facet {
namespace {

/// True path travelled up to each pair (m).
std::vector<double> distances(std::span<const PosePair> pairs) {
    std::vector<double> travelled(pairs.size(), 0.0);
    for (std::size_t i = 1; i < pairs.size(); ++i) {
        travelled[i] = travelled[i - 1] + (pairs[i].truth.p - pairs[i - 1].truth.p).norm();
    }
    return travelled;
}

double overlap_s(Timestamp a0, Timestamp a1, Timestamp b0, Timestamp b1) {
    return std::max(0.0, (std::min(a1, b1) - std::max(a0, b0)).seconds());
}

double share(double part, double whole) { return whole > 0.0 ? part / whole : 0.0; }

}  // namespace

ErrorStatistics error_statistics(std::vector<double> errors) {
    ErrorStatistics s;
    const OrderStatistics order(std::move(errors));
    s.count = order.count();
    if (s.count == 0) {
        return s;
    }
    double square_sum = 0.0;
    double sum = 0.0;
    for (const double e : order.sorted()) {
        sum += e;
        square_sum += e * e;
    }
    s.mean = sum / static_cast<double>(s.count);
    s.rmse = std::sqrt(square_sum / static_cast<double>(s.count));
    s.median = order.median();
    s.max = order.max();
    return s;
}

AbsoluteError absolute_error(std::span<const PosePair> pairs, AlignmentMode mode) {
    AbsoluteError result;
    result.mode = mode;
    result.T_true_est = align(pairs, mode);
    std::vector<double> translation;
    std::vector<double> rotation;
    for (const PosePair& pair : pairs) {
        const PoseDifference error = pose_difference(pair.truth, result.T_true_est * pair.estimate);
        translation.push_back(error.distance_m());
        rotation.push_back(error.angle_deg());
    }
    result.translation_m = error_statistics(std::move(translation));
    result.rotation_deg = error_statistics(std::move(rotation));
    return result;
}

std::vector<RelativeSample> relative_samples(std::span<const PosePair> pairs, double length_m) {
    const std::vector<double> travelled = distances(pairs);
    const Se3 T_true_est = align(pairs, AlignmentMode::kYaw4);
    std::vector<RelativeSample> samples;
    std::size_t j = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        while (j < pairs.size() && travelled[j] - travelled[i] < length_m) {
            ++j;
        }
        if (j == pairs.size()) {
            break;
        }
        const Se3 true_motion = pairs[i].truth.inverse() * pairs[j].truth;
        const Se3 motion = pairs[i].estimate.inverse() * pairs[j].estimate;
        const PoseDifference error = pose_difference({}, true_motion.inverse() * motion);
        // Turns seen from the world: R_W_Bj R_W_Bi^T; the estimate's world is turned into the true one first.
        const Eigen::Quaterniond true_turn = pairs[j].truth.q * pairs[i].truth.q.conjugate();
        const Eigen::Quaterniond turn =
            T_true_est.q * pairs[j].estimate.q * pairs[i].estimate.q.conjugate() * T_true_est.q.conjugate();
        samples.push_back({.stamp = pairs[i].stamp,
                           .stretch_m = travelled[j] - travelled[i],
                           .translation_m = error.distance_m(),
                           .rotation_deg = error.angle_deg(),
                           .yaw_deg = std::abs(so3_log((turn * true_turn.conjugate()).normalized()).z()) * kDegPerRad});
    }
    return samples;
}

RelativeError relative_error(std::span<const PosePair> pairs, double length_m) {
    std::vector<double> translation;
    std::vector<double> percent;
    std::vector<double> rotation;
    std::vector<double> rotation_per_m;
    std::vector<double> yaw;
    for (const RelativeSample& sample : relative_samples(pairs, length_m)) {
        translation.push_back(sample.translation_m);
        percent.push_back(sample.translation_percent());
        rotation.push_back(sample.rotation_deg);
        rotation_per_m.push_back(sample.rotation_deg / sample.stretch_m);
        yaw.push_back(sample.yaw_deg);
    }
    return {.length_m = length_m,
            .translation_m = error_statistics(std::move(translation)),
            .translation_percent = error_statistics(std::move(percent)),
            .rotation_deg = error_statistics(std::move(rotation)),
            .rotation_deg_per_m = error_statistics(std::move(rotation_per_m)),
            .yaw_deg = error_statistics(std::move(yaw))};
}

Coverage coverage(const Trajectory& truth, const Trajectory& estimate, std::span<const Timestamp> frames) {
    Coverage result;
    if (truth.empty()) {
        return result;
    }
    const Timestamp begin = truth.front().stamp;
    const Timestamp end = truth.back().stamp;
    std::vector<Timestamp> seen;
    std::copy_if(frames.begin(), frames.end(), std::back_inserter(seen),
                 [&](Timestamp t) { return t >= begin && t <= end; });
    result.has_frames = !seen.empty();
    result.frames = seen.size();
    if (estimate.empty()) {
        return result;
    }
    const Timestamp first = estimate.front().stamp;
    const Timestamp last = estimate.back().stamp;
    result.truth_span = share(overlap_s(begin, end, first, last), (end - begin).seconds());
    result.time = result.truth_span;
    if (seen.size() < 2) {
        return result;
    }
    result.time = share(overlap_s(seen.front(), seen.back(), first, last), (seen.back() - seen.front()).seconds());
    const Duration tolerance{(seen.back() - seen.front()).ns / static_cast<std::int64_t>(4 * (seen.size() - 1))};
    for (const Timestamp t : seen) {
        const auto near = std::lower_bound(estimate.begin(), estimate.end(), t - tolerance,
                                           [](const StampedPose& p, Timestamp s) { return p.stamp < s; });
        result.frames_matched += near != estimate.end() && near->stamp <= t + tolerance ? 1 : 0;
    }
    return result;
}

Evaluation evaluate(const Trajectory& truth, const Trajectory& estimate, std::span<const Timestamp> frames,
                    const EvaluationOptions& options) {
    Evaluation result;
    const std::vector<PosePair> pairs = associate(truth, estimate, options.max_truth_gap);
    result.truth_poses = truth.size();
    result.estimate_poses = estimate.size();
    result.matched = pairs.size();
    result.se3 = absolute_error(pairs, AlignmentMode::kSe3);
    result.yaw4 = absolute_error(pairs, AlignmentMode::kYaw4);
    result.scale = similarity_scale(pairs);
    result.truth_fit = fit_truth(pairs);
    for (const double length : options.rpe_lengths_m) {
        result.relative.push_back(relative_error(pairs, length));
    }
    result.coverage = coverage(truth, estimate, frames);
    if (!pairs.empty()) {
        result.path_m = distances(pairs).back();
        result.duration_s = (pairs.back().stamp - pairs.front().stamp).seconds();
        const Se3 T_true_est = pairs.front().truth * pairs.front().estimate.inverse();
        result.end_drift_m = (pairs.back().truth.p - T_true_est * pairs.back().estimate.p).norm();
    }
    return result;
}

}  // namespace facet
