// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/planes/slant_votes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace facet {
namespace {

const float kLeastCosine = static_cast<float>(std::cos(SlantVotes::kReach_rad));

/// Share of a vote at this cosine of the angle to the normal: 1 at the normal, 0 from kReach_rad on, smooth between.
float share(float cosine) {
    const float x = std::max(0.0F, (cosine - kLeastCosine) / (1.0F - kLeastCosine));
    return x * x;
}

}  // namespace

/// Directions evenly spread over the sphere: a spiral from pole to pole, turned by the golden angle at each step, the
/// steps of equal area.
SlantVotes::SlantVotes() {
    const double golden = std::numbers::pi * (3.0 - std::sqrt(5.0));
    for (std::size_t i = 0; i < kDirections; ++i) {
        const double z = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / kDirections;
        const double level = std::sqrt(1.0 - z * z);
        const double azimuth = golden * static_cast<double>(i);
        direction_[0][i] = static_cast<float>(level * std::cos(azimuth));
        direction_[1][i] = static_cast<float>(level * std::sin(azimuth));
        direction_[2][i] = static_cast<float>(z);
    }
}

void SlantVotes::begin(const Eigen::Vector3d& origin_W, double max_tilt_rad) {
    origin_ = origin_W;
    least_sine_ = static_cast<float>(std::sin(max_tilt_rad));
    votes_.fill(0.0F);
    voters_.clear();
    peaks_.clear();
}

void SlantVotes::add(const Voter& voter, float sign) {
    const Eigen::Vector3f& n = voter.normal_W;
    const float weight = sign * voter.weight;
    for (std::size_t i = 0; i < kDirections; ++i) {
        votes_[i] += weight * share(n.x() * direction_[0][i] + n.y() * direction_[1][i] + n.z() * direction_[2][i]);
    }
}

void SlantVotes::vote(const Eigen::Vector3f& normal_W, const Eigen::Vector3f& from_origin, float weight) {
    if (voters_.full()) {
        return;
    }
    voters_.push_back({normal_W, from_origin, weight});
    add(voters_.back(), 1.0F);
}

bool SlantVotes::is_slanted(const Eigen::Vector3f& normal_W) const {
    return normal_W.head<2>().norm() > least_sine_ && std::abs(normal_W.z()) > least_sine_;
}

/// @return zero if no face is turned like that
Eigen::Vector3f SlantVotes::mean_normal(const Eigen::Vector3f& around) const {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (const Voter& v : voters_) {
        sum += v.weight * share(v.normal_W.dot(around)) * v.normal_W;
    }
    return sum.norm() > 0.0F ? sum.normalized() : Eigen::Vector3f::Zero();
}

/// The faces around a direction that agree best in their distance; takes them out.
PlanePeak SlantVotes::take_strongest(const Eigen::Vector3f& normal_W) {
    near_.clear();
    for (std::size_t i = 0; i < voters_.size(); ++i) {
        const Voter& v = voters_[i];
        if (const float weight = v.weight * share(v.normal_W.dot(normal_W)); weight > 0.0F) {
            near_.push_back({normal_W.dot(v.from_origin), weight, i});
        }
    }
    std::sort(near_.begin(), near_.end(), [](const Near& a, const Near& b) {
        return a.distance_m != b.distance_m ? a.distance_m < b.distance_m : a.voter < b.voter;
    });
    struct Window {
        std::size_t begin = 0;
        std::size_t end = 0;
        float weight = 0.0F;
        float moment = 0.0F;  ///< weight times distance
    };
    Window best;
    Window window;
    for (const Near& last : near_) {
        ++window.end;
        window.weight += last.weight;
        window.moment += last.weight * last.distance_m;
        for (; near_[window.begin].distance_m < last.distance_m - kWindow_m; ++window.begin) {
            window.weight -= near_[window.begin].weight;
            window.moment -= near_[window.begin].weight * near_[window.begin].distance_m;
        }
        best = window.weight > best.weight ? window : best;
    }
    for (std::size_t i = best.begin; i < best.end; ++i) {
        Voter& v = voters_[near_[i].voter];
        add(v, -1.0F);
        v.weight = 0.0F;
    }
    PlanePeak peak;
    peak.kind = PlaneKind::kSlanted;
    peak.normal_W = normal_W.cast<double>().normalized();
    peak.distance_m = peak.normal_W.dot(origin_) + static_cast<double>(best.moment / std::max(best.weight, 1e-9F));
    peak.support_m2 = best.weight;
    return peak;
}

std::span<const PlanePeak> SlantVotes::find_peaks(float min_support_m2) {
    for (int round = 0; round < kMaxRounds && !peaks_.full(); ++round) {
        const auto* const at = std::max_element(votes_.begin(), votes_.end());
        if (!(*at >= min_support_m2)) {
            break;
        }
        const auto i = static_cast<std::size_t>(at - votes_.begin());
        Eigen::Vector3f normal_W = mean_normal({direction_[0][i], direction_[1][i], direction_[2][i]});
        normal_W = mean_normal(normal_W);
        const PlanePeak peak = take_strongest(normal_W);
        if (is_slanted(normal_W) && peak.support_m2 >= min_support_m2) {
            peaks_.push_back(peak);
        }
    }
    return {peaks_.data(), peaks_.size()};
}

}  // namespace facet
