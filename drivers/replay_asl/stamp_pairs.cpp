// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/replay_asl/stamp_pairs.h"

#include <algorithm>
#include <cstdlib>
#include <optional>

namespace facet {
namespace {

using Stamps = std::span<const Timestamp>;
using Kind = StampPair::Kind;

Duration half_period(Stamps stamps) {
    std::vector<Duration> steps;
    for (std::size_t i = 1; i < stamps.size(); ++i) {
        steps.push_back(stamps[i] - stamps[i - 1]);
    }
    return {summarize_skews(steps).median.ns / 2};
}

Duration distance(Timestamp a, Timestamp b) { return {std::abs((a - b).ns)}; }

/// The nearest of `others` within `limit` that is not taken.
std::optional<std::size_t> nearest(Timestamp stamp, Stamps others, Duration limit, const std::vector<bool>& taken) {
    std::optional<std::size_t> found;
    auto at = static_cast<std::size_t>(std::lower_bound(others.begin(), others.end(), stamp - limit) - others.begin());
    for (; at < others.size() && others[at] <= stamp + limit; ++at) {
        if (!taken[at] && (!found || distance(stamp, others[at]) < distance(stamp, others[*found]))) {
            found = at;
        }
    }
    return found;
}

}  // namespace

std::vector<StampPair> pair_stamps(Stamps left, Stamps right, Duration tolerance) {
    const Duration half = half_period(left);
    std::vector<StampPair> pairs(left.size());
    std::vector<bool> taken(right.size(), false);
    for (const bool is_together : {true, false}) {
        for (std::size_t i = 0; i < left.size(); ++i) {
            StampPair& pair = pairs[i];
            pair.left = i;
            if (pair.right != StampPair::kNone) {
                continue;
            }
            if (const auto found = nearest(left[i], right, is_together ? tolerance : half, taken)) {
                pair.kind = is_together ? Kind::kTogether : Kind::kApart;
                pair.right = *found;
                taken[*found] = true;
            }
        }
    }
    const std::vector<bool> none(left.size(), false);
    for (std::size_t j = 0; j < right.size(); ++j) {
        if (!taken[j]) {
            const bool is_surplus = nearest(right[j], left, half, none).has_value();
            pairs.push_back({is_surplus ? Kind::kSurplus : Kind::kRightOnly, StampPair::kNone, j});
        }
    }
    const auto stamp = [&](const StampPair& p) { return p.left != StampPair::kNone ? left[p.left] : right[p.right]; };
    std::stable_sort(pairs.begin(), pairs.end(),
                     [&](const StampPair& a, const StampPair& b) { return stamp(a) < stamp(b); });
    return pairs;
}

StampSkew summarize_skews(std::span<Duration> skews) {
    if (skews.empty()) {
        return {};
    }
    std::sort(skews.begin(), skews.end());
    return {skews.size(), skews[skews.size() / 2], skews.front(), skews.back()};
}

}  // namespace facet
