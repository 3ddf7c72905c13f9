// SPDX-License-Identifier: BSD-2-Clause
#include <algorithm>
#include <array>

#include "mesh/places/place_pose.h"

namespace facet {
namespace {

/// Codes of two points differ in 128 comparisons on average, with a standard deviation of 8 or more: 80 is rare.
constexpr int kMaxBits = 80;
/// Of a point and the most similar one of another place 40 to 70 differ. Of places recognised in a building, and in the
/// dark in a room, every one had five matches or more below 30.
constexpr int kSureBits = 30;
constexpr int kSureMatches = 5;

struct Best {
    int distance = kMaxBits + 1;
    std::uint16_t index = 0;
};

}  // namespace

void match_points(std::span<const PlacePoint> seen, std::span<const PlacePoint> known, PointMatches& matches) {
    matches.clear();
    std::array<Best, kMaxPlacePoints> best_seen;  // of each known point
    std::array<Best, kMaxPlacePoints> best_known;
    for (std::size_t i = 0; i < seen.size(); ++i) {
        for (std::size_t j = 0; j < known.size(); ++j) {
            const int d = seen[i].code.distance_to(known[j].code);
            if (d < best_known[i].distance) {
                best_known[i] = {d, static_cast<std::uint16_t>(j)};
            }
            if (d < best_seen[j].distance) {
                best_seen[j] = {d, static_cast<std::uint16_t>(i)};
            }
        }
    }
    for (std::size_t i = 0; i < seen.size(); ++i) {
        const Best& best = best_known[i];
        if (best.distance <= kMaxBits && best_seen[best.index].index == i) {
            matches.push_back({static_cast<std::uint16_t>(i), best.index, static_cast<std::uint16_t>(best.distance)});
        }
    }
}

bool is_promising(const PointMatches& matches) {
    return std::ranges::count_if(matches, [](const PointMatch& m) { return m.distance < kSureBits; }) >= kSureMatches;
}

}  // namespace facet
