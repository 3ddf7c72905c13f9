// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/volume/depth_growth.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace facet {
namespace {

constexpr double kMostApartPx = 4.0;  // px of disparity: depths around that differ by more are not of one surface
constexpr double kMarginPx = 4.0;     // searched beyond them
constexpr int kFewAround = 2;         // depths around: what is not found near these may be elsewhere
constexpr int kMostInVain = 3;        // squares around where all depths were searched: one more is not worth it

/// Coprime to `count`, and near its golden section: multiples of it soon cover all of a row.
int coprime_stride(int count) {
    constexpr double kGolden = 0.6180339887498949;
    int stride = std::max(1, static_cast<int>(kGolden * count));
    while (std::gcd(stride, count) > 1) {
        ++stride;
    }
    return stride;
}

}  // namespace

DepthGrowth::DepthGrowth(DepthSampler& sampler) : sampler_(sampler), stride_(coprime_stride(sampler.count())) {
    const auto squares = static_cast<std::size_t>(sampler.count());
    states_.assign(squares, State::kNew);
    seeds_.assign(squares, 0.0F);
    queue_.reserve(2 * squares);
}

void DepthGrowth::begin(std::span<const DepthSeed> seeds) {
    std::ranges::fill(states_, State::kNew);
    std::ranges::fill(seeds_, 0.0F);
    queue_.clear();
    next_queued_ = 0;
    next_ = 0;
    for (const DepthSeed& seed : seeds) {
        seeds_[static_cast<std::size_t>(seed.square)] = seed.inverse_depth;
        if (state(seed.square) == State::kNew) {
            state(seed.square) = State::kQueued;
            queue_.push_back(seed.square);
        }
    }
}

int DepthGrowth::advance(const ImagePyramid& left, const ImagePyramid& right, std::span<DepthSample> samples) {
    if (next_queued_ < queue_.size()) {
        return grow(queue_[next_queued_++], left, right, samples);
    }
    const int count = sampler_.count();
    while (next_ < count) {
        const auto square = static_cast<int>(static_cast<std::int64_t>(next_++) * stride_ % count);
        if (state(square) == State::kNew || state(square) == State::kMissed) {
            return search(square, left, right, samples);
        }
    }
    return -1;
}

template <class Visit>
void DepthGrowth::visit_around(int square, const Visit& visit) const {
    const int column = square % sampler_.columns();
    const int row = square / sampler_.columns();
    for (int r = std::max(0, row - 1); r <= std::min(sampler_.rows() - 1, row + 1); ++r) {
        for (int c = std::max(0, column - 1); c <= std::min(sampler_.columns() - 1, column + 1); ++c) {
            visit(r * sampler_.columns() + c);
        }
    }
}

/// The square's own seed counts as a neighbour.
DepthGrowth::Surroundings DepthGrowth::around(int square, std::span<const DepthSample> samples) const {
    Surroundings found;
    const auto add = [&](float inverse_depth) {
        const auto rho = static_cast<double>(inverse_depth);
        found.range = found.known == 0
                          ? DepthRange{rho, rho}
                          : DepthRange{std::min(found.range.farthest, rho), std::max(found.range.nearest, rho)};
        ++found.known;
    };
    visit_around(square, [&](int other) {
        const auto at = static_cast<std::size_t>(other);
        found.in_vain += states_[at] == State::kInVain ? 1 : 0;
        if (states_[at] == State::kKnown) {
            add(samples[at].inverse_depth);
        }
    });
    if (const float seed = seeds_[static_cast<std::size_t>(square)]; seed > 0.0F) {
        add(seed);
    }
    return found;
}

int DepthGrowth::grow(int square, const ImagePyramid& left, const ImagePyramid& right, std::span<DepthSample> samples) {
    const Surroundings near = around(square, samples);
    const double per_px = sampler_.per_px();
    if (near.range.nearest - near.range.farthest > kMostApartPx * per_px) {
        state(square) = State::kNew;
        return 0;
    }
    const double margin = kMarginPx * per_px;
    const int places =
        match(square, {std::max(0.0, near.range.farthest - margin), near.range.nearest + margin}, left, right, samples);
    if (state(square) == State::kQueued) {
        state(square) = near.known > kFewAround ? State::kInVain : State::kMissed;
    }
    return places;
}

int DepthGrowth::search(int square, const ImagePyramid& left, const ImagePyramid& right,
                        std::span<DepthSample> samples) {
    const Surroundings near = around(square, samples);
    if (near.known == 0 && near.in_vain >= kMostInVain) {
        state(square) = State::kLeftOut;
        return 0;
    }
    const int places = match(square, sampler_.all_depths(), left, right, samples);
    if (state(square) == State::kNew || state(square) == State::kMissed) {
        state(square) = State::kInVain;
    }
    return places;
}

/// Marks the square as known or without texture, and its neighbours as worth a search. @return places compared
int DepthGrowth::match(int square, const DepthRange& range, const ImagePyramid& left, const ImagePyramid& right,
                       std::span<DepthSample> samples) {
    DepthSample& sample = samples[static_cast<std::size_t>(square)];
    const bool has_pixel = !sample.gradient.isZero();  // since an earlier search
    if (!has_pixel && !sampler_.find_pixel(square, left, sample)) {
        state(square) = State::kLeftOut;
        return 0;
    }
    if (sampler_.match(left, right, range, sample)) {
        state(square) = State::kKnown;
        visit_around(square, [&](int other) {
            if (state(other) == State::kNew || (state(other) == State::kMissed && queue_.size() < queue_.capacity())) {
                state(other) = State::kQueued;
                queue_.push_back(other);
            }
        });
    }
    return static_cast<int>((range.nearest - range.farthest) / sampler_.per_px());
}

}  // namespace facet
