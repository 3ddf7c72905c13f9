// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/imu/delay_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace facet {
namespace {

constexpr double kStep_s = 5e-3;
// Neighbouring turns share the errors of a track: their sum's variance is about this much larger.
constexpr double kAlike = 4.0;
// A delay is believed if it explains all but this share of what the turns differ from their mean by.
constexpr double kMostUnexplained = 0.1;
// A vehicle that turns by less than four times a milliradian from image to image is not worth the work.
constexpr double kLeastSpread_rad2 = 4e-6;
constexpr double kLongestTurn_s = 0.12;
// Many turns tell their noise themselves, down to this share of the variance expected.
constexpr double kLeastNoise = 0.01;
// By which VibrationMeter underrates a turn's variance under rotors whose shaking images do not show: four sequences,
// 0.45 mrad for 0.65 as the mean of the axes.
constexpr double kUnseenShaking = 2.0;

/// What the samples of a step add to the variance of a turn of this length, the mean of the axes.
double shake_rad2(const VibrationLevel& level, double step_s, double turn_s) {
    const Eigen::Vector3d edge = VibrationMeter::edge_variances(level, 0, 1.0, 1.0 / step_s);
    const double white = static_cast<double>(level.white().head<3>().mean()) * step_s * turn_s;
    return kUnseenShaking * (2.0 * edge.mean() + white);
}

}  // namespace

Eigen::Vector3d DelaySearch::angle_at(Timestamp t) const {
    const auto after = std::lower_bound(angles_.begin() + 1, angles_.end() - 1, t,
                                        [](const Angle& a, Timestamp stamp) { return a.stamp < stamp; });
    const auto before = after - 1;
    const double share = (t - before->stamp).seconds() / (after->stamp - before->stamp).seconds();
    return before->value + share * (after->value - before->value);
}

void DelaySearch::add(Timestamp begin, Timestamp end, const Eigen::Vector3d& turn_B) {
    const double length_s = (end - begin).seconds();
    const bool is_usable = length_s > 0.0 && length_s < kLongestTurn_s && turn_B.allFinite();
    const bool goes_on = turns_.empty() || (begin >= turns_.back().begin && begin <= turns_.back().end);
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

DelaySearch::Turns DelaySearch::covered(double least_s, double most_s) const {
    Turns turns(turns_.data(), turns_.size());
    while (!turns.empty() && turns.back().end + Duration::from_seconds(most_s) > angles_.back().stamp) {
        turns = turns.first(turns.size() - 1);
    }
    while (!turns.empty() && turns.front().begin + Duration::from_seconds(least_s) < angles_.front().stamp) {
        turns = turns.subspan(1);
    }
    return turns;
}

DelaySearch::Turns DelaySearch::covered_at(int step, double believed_s) const {
    return covered(std::min(believed_s, (step - 1) * kStep_s), std::max(believed_s, (step + 1) * kStep_s));
}

double DelaySearch::misfit(Turns turns, double delay_s) const {
    const Duration delay = Duration::from_seconds(delay_s);
    Eigen::Vector3d moment = Eigen::Vector3d::Zero();
    double time2 = 0.0;
    double squares = 0.0;
    for (const Turn& turn : turns) {
        const double dt = (turn.end - turn.begin).seconds();
        const Eigen::Vector3d off = turn.turn_B - (angle_at(turn.end + delay) - angle_at(turn.begin + delay));
        moment += dt * off;
        time2 += dt * dt;
        squares += off.squaredNorm();
    }
    return squares - moment.squaredNorm() / time2;
}

Status DelaySearch::integrate(const ImuBuffer& imu, Timestamp begin, Timestamp end) {
    angles_.clear();
    angles_.push_back({begin, Eigen::Vector3d::Zero()});
    const double turn_s = (turns_.back().end - turns_.front().begin).seconds() / static_cast<double>(turns_.size());
    Eigen::Vector3d angle = Eigen::Vector3d::Zero();
    bool is_whole = true;
    int steps = 0;
    shake_rad2_ = 0.0;
    FACET_TRY(imu.for_each_step(begin, end, [&](const ImuSample& a, const ImuSample& b, const ImuStepQuality& quality) {
        const double step_s = (b.stamp - a.stamp).seconds();
        angle += 0.5 * step_s * (a.w_B + b.w_B);
        is_whole = is_whole && quality.gap == Duration{} && quality.clipped == 0;
        shake_rad2_ += shake_rad2(quality.vibration, step_s, turn_s);
        ++steps;
        if ((b.stamp - angles_.back().stamp).seconds() < kAngleSpacing_s && b.stamp < end) {
            return;
        }
        if (angles_.size() < angles_.capacity()) {
            angles_.push_back({b.stamp, angle});
        } else {
            is_whole = false;
        }
    }));
    shake_rad2_ /= std::max(1, steps);
    return is_whole && angles_.size() > 2 ? Status::kOk : Status::kNotReady;
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

double DelaySearch::variance(Turns turns, double squares) const {
    const double seen_rad2 = squares / (3.0 * static_cast<double>(turns.size()) - 4.0);
    const double least_rad2 = turns.size() < kManyTurns ? expected_rad2() : kLeastNoise * expected_rad2();
    return std::max(seen_rad2, least_rad2);
}

int DelaySearch::best_step(double believed_s) const {
    int best = kSteps;
    double most = -std::numeric_limits<double>::infinity();
    for (int k = -kSteps; k <= kSteps; ++k) {
        const Turns turns = covered_at(k, believed_s);
        if (turns.size() < kFewestTurns) {
            continue;
        }
        const double gain = misfit(turns, believed_s) - misfit(turns, k * kStep_s);
        if (gain > most) {
            most = gain;
            best = k;
        }
    }
    return best;
}

DelaySearch::Parabola DelaySearch::parabola(double believed_s) const {
    Parabola p;
    p.step = best_step(believed_s);
    // A neighbour that has fewer turns may be better over these.
    for (int i = 0; i < 2 * kSteps && std::abs(p.step) < kSteps; ++i) {
        p.turns = covered_at(p.step, believed_s);
        p.before = misfit(p.turns, (p.step - 1) * kStep_s);
        p.least = misfit(p.turns, p.step * kStep_s);
        p.after = misfit(p.turns, (p.step + 1) * kStep_s);
        const int next = p.step + (p.after < p.least ? 1 : p.before < p.least ? -1 : 0);
        if (next == p.step || covered_at(next, believed_s).size() < kFewestTurns) {
            break;
        }
        p.step = next;
    }
    return p;
}

Status DelaySearch::solve(const ImuBuffer& imu, double believed_s, DelayFit& fit) {
    fit = {};
    if (turns_.size() < kFewestTurns || imu.empty() || spread({turns_.data(), turns_.size()}) < kLeastSpread_rad2) {
        return Status::kNotReady;
    }
    const Duration range = Duration::from_seconds(kRange_s + kStep_s);
    FACET_TRY(integrate(imu, std::max(turns_.front().begin - range, imu.oldest()),
                        std::min(turns_.back().end + range, imu.newest())));
    const Turns all = covered(believed_s, believed_s);
    if (all.size() < kFewestTurns) {
        return Status::kNotReady;
    }
    const double freedom = 3.0 * static_cast<double>(all.size()) - 3.0;
    fit.misfit = misfit(all, believed_s) / freedom / expected_rad2();
    const Parabola p = parabola(believed_s);
    if (std::abs(p.step) == kSteps) {
        return Status::kDegenerate;
    }
    const double curvature = 0.5 * (p.before + p.after - 2.0 * p.least) / (kStep_s * kStep_s);
    const double noise = kAlike * variance(p.turns, p.least);
    fit.gain = (misfit(p.turns, believed_s) - p.least) / noise;
    fit.delay = {p.step * kStep_s, kRange_s};
    const bool is_least = p.least <= std::min(p.before, p.after);  // else samples for what is better are yet to come
    if (!is_least || !(noise < curvature * kMostSigma_s * kMostSigma_s)) {
        return Status::kNotReady;
    }
    fit.delay.value_s += 0.25 * (p.before - p.after) / (curvature * kStep_s);
    fit.delay.sigma_s = std::sqrt(noise / curvature);
    return p.least > kMostUnexplained * spread(p.turns) ? Status::kDegenerate : Status::kOk;
}

}  // namespace facet
