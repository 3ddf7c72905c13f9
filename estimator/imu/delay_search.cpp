// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/imu/delay_search.h"

#include <algorithm>
#include <cmath>

namespace facet {
namespace {

constexpr double kStep_s = 5e-3;
// Neighbouring turns share the errors of a track: their sum's variance is about this much larger.
constexpr double kAlike = 4.0;
// A delay is believed if it explains all but this share of what the turns differ from their mean by.
constexpr double kMostUnexplained = 0.1;
// A vehicle that turns by less from image to image is not worth the work.
constexpr double kLeastTurn_rad = 1e-3;
constexpr double kLongestTurn_s = 0.12;

}  // namespace

Eigen::Vector3d DelaySearch::at(const Angles& angles, Timestamp t) {
    const auto after = std::lower_bound(angles.begin() + 1, angles.end() - 1, t,
                                        [](const Angle& a, Timestamp stamp) { return a.stamp < stamp; });
    const auto before = after - 1;
    const double share = (t - before->stamp).seconds() / (after->stamp - before->stamp).seconds();
    return before->value + share * (after->value - before->value);
}

void DelaySearch::reset() { turns_.clear(); }

void DelaySearch::add(Timestamp begin, Timestamp end, const Eigen::Vector3d& turn_B) {
    const double length_s = (end - begin).seconds();
    const bool is_usable = length_s > 0.0 && length_s < kLongestTurn_s && turn_B.allFinite();
    const bool goes_on = turns_.empty() || turns_.back().end == begin;
    if (!is_usable || !goes_on) {
        turns_.clear();
    }
    if (!is_usable) {
        return;
    }
    while (turns_.size() == turns_.capacity() ||
           (!turns_.empty() && (end - turns_.front().begin).seconds() > kSpan_s)) {
        turns_.erase(turns_.begin());
    }
    turns_.push_back({begin, end, turn_B});
}

double DelaySearch::misfit(Turns turns, const Angles& angles, double delay_s) {
    const Duration delay = Duration::from_seconds(delay_s);
    Eigen::Vector3d moment = Eigen::Vector3d::Zero();
    double time2 = 0.0;
    double squares = 0.0;
    for (const Turn& turn : turns) {
        const double dt = (turn.end - turn.begin).seconds();
        const Eigen::Vector3d off = turn.turn_B - (at(angles, turn.end + delay) - at(angles, turn.begin + delay));
        moment += dt * off;
        time2 += dt * dt;
        squares += off.squaredNorm();
    }
    return squares - moment.squaredNorm() / time2;
}

Status DelaySearch::integrate(const ImuBuffer& imu, Timestamp begin, Timestamp end, Angles& out) {
    out.clear();
    out.push_back({begin, Eigen::Vector3d::Zero()});
    Eigen::Vector3d angle = Eigen::Vector3d::Zero();
    bool is_whole = true;
    FACET_TRY(imu.for_each_step(begin, end, [&](const ImuSample& a, const ImuSample& b, const ImuStepQuality& quality) {
        angle += 0.5 * (b.stamp - a.stamp).seconds() * (a.w_B + b.w_B);
        is_whole = is_whole && quality.gap == Duration{} && quality.clipped == 0;
        if ((b.stamp - out.back().stamp).seconds() < kAngleSpacing_s && b.stamp < end) {
            return;
        }
        if (out.size() < out.capacity()) {
            out.push_back({b.stamp, angle});
        } else {
            is_whole = false;
        }
    }));
    return is_whole && out.size() > 2 ? Status::kOk : Status::kNotReady;
}

double DelaySearch::spread(Turns turns) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const Turn& turn : turns) {
        mean += turn.turn_B / static_cast<double>(turns.size());
    }
    double squares = 0.0;
    for (const Turn& turn : turns) {
        squares += (turn.turn_B - mean).squaredNorm();
    }
    return squares;
}

Status DelaySearch::solve(const ImuBuffer& imu, ImageDelay& found) {
    const Duration range = Duration::from_seconds(kRange_s + kStep_s);
    Turns turns(turns_.data(), turns_.size());
    while (!turns.empty() && (imu.empty() || turns.back().end + range > imu.newest())) {
        turns = turns.first(turns.size() - 1);
    }
    if (turns.size() < kFewestTurns || turns.front().begin - range < imu.oldest()) {
        return Status::kNotReady;
    }
    const auto n = static_cast<double>(turns.size());
    const double squares = spread(turns);
    if (squares < n * kLeastTurn_rad * kLeastTurn_rad) {
        return Status::kNotReady;
    }
    FACET_TRY(integrate(imu, turns.front().begin - range, turns.back().end + range, angles_));
    int best = 0;
    double least = misfit(turns, angles_, 0.0);
    for (int k = -kSteps; k <= kSteps; ++k) {
        if (const double value = misfit(turns, angles_, k * kStep_s); value < least) {
            least = value;
            best = k;
        }
    }
    const double before = misfit(turns, angles_, (best - 1) * kStep_s);
    const double after = misfit(turns, angles_, (best + 1) * kStep_s);
    const double curvature = 0.5 * (before + after - 2.0 * least) / (kStep_s * kStep_s);
    const double variance = kAlike * least / (3.0 * n - 4.0);
    if (!(variance < curvature * kMostSigma_s * kMostSigma_s)) {
        return Status::kNotReady;
    }
    if (std::abs(best) == kSteps || least > kMostUnexplained * squares) {
        return Status::kDegenerate;
    }
    found.value_s = best * kStep_s + 0.25 * (before - after) / (curvature * kStep_s);
    found.sigma_s = std::sqrt(variance / curvature);
    return Status::kOk;
}

}  // namespace facet
