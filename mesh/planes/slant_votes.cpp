// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/planes/slant_votes.h"

#include <algorithm>
#include <cmath>

namespace facet {
namespace {

const float kLeastCosine = static_cast<float>(std::cos(SlantVotes::kReach_rad));

/// Share of a vote at this cosine of the angle to the normal: 1 at the normal, 0 from kReach_rad on, smooth between.
float share(float cosine) {
    const float x = std::max(0.0F, (cosine - kLeastCosine) / (1.0F - kLeastCosine));
    return x * x;
}

}  // namespace

SlantVotes::SlantVotes() {
    for (std::size_t cell = 0; cell < kCells; ++cell) {
        const std::size_t side = cell / (kSide * kSide);
        const auto middle = [](std::size_t i) { return (2.0F * static_cast<float>(i) + 1.0F) / kSide - 1.0F; };
        const auto axis = static_cast<Eigen::Index>(side / 2);
        Eigen::Vector3f& d = direction_[cell];
        d(axis) = side % 2 == 0 ? 1.0F : -1.0F;
        d((axis + 1) % 3) = middle(cell % kSide);
        d((axis + 2) % 3) = middle(cell / kSide % kSide);
        d.normalize();
    }
    for (std::size_t a = 0; a < kCells; ++a) {
        for (std::size_t b = 0; b < kCells; ++b) {
            if (const float part = share(direction_[a].dot(direction_[b])); part > 0.0F) {
                static_cast<void>(near_cells_[a].try_push_back({static_cast<std::uint16_t>(b), part}));
            }
        }
    }
}

void SlantVotes::begin(const Eigen::Vector3d& origin_W, double max_tilt_rad) {
    origin_ = origin_W;
    least_sine_ = static_cast<float>(std::sin(max_tilt_rad));
    votes_.fill(0.0F);
    normals_.fill(Eigen::Vector3f::Zero());
    voters_.clear();
    peaks_.clear();
}

/// @param direction  unit
std::uint16_t SlantVotes::cell_of(const Eigen::Vector3f& direction) {
    Eigen::Index axis = 0;
    const float largest = direction.cwiseAbs().maxCoeff(&axis);
    const auto at = [&](Eigen::Index k) {
        const float x = 0.5F * kSide * (1.0F + direction((axis + k) % 3) / largest);
        return std::min(kSide - 1, static_cast<int>(x));
    };
    const int side = 2 * static_cast<int>(axis) + (direction(axis) > 0.0F ? 0 : 1);
    return static_cast<std::uint16_t>((side * kSide + at(2)) * kSide + at(1));
}

void SlantVotes::count(const Voter& voter, float sign) {
    const float weight = sign * voter.weight;
    normals_[voter.cell] += weight * voter.normal_W;
    for (const Share& near : near_cells_[voter.cell]) {
        votes_[near.cell] += weight * near.share;
    }
}

void SlantVotes::vote(const Eigen::Vector3f& normal_W, const Eigen::Vector3f& from_origin, float weight) {
    if (voters_.full() || !(normal_W.squaredNorm() > 0.5F)) {  // a normal without direction, or NaN
        return;
    }
    voters_.push_back({normal_W, from_origin, weight, cell_of(normal_W)});
    count(voters_.back(), 1.0F);
}

bool SlantVotes::is_slanted(const Eigen::Vector3f& normal_W) const {
    return normal_W.head<2>().norm() > least_sine_ && std::abs(normal_W.z()) > least_sine_;
}

/// @return zero if no face is turned like that
Eigen::Vector3f SlantVotes::mean_normal(const Eigen::Vector3f& around) const {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (std::size_t cell = 0; cell < kCells; ++cell) {
        sum += share(direction_[cell].dot(around)) * normals_[cell];
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
        count(v, -1.0F);
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
        const auto strongest = static_cast<std::size_t>(at - votes_.begin());
        const Eigen::Vector3f normal_W = mean_normal(mean_normal(direction_[strongest]));
        const PlanePeak peak = take_strongest(normal_W);
        if (is_slanted(normal_W) && peak.support_m2 >= min_support_m2) {
            peaks_.push_back(peak);
        }
    }
    return {peaks_.data(), peaks_.size()};
}

}  // namespace facet
