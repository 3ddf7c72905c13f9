// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/volume/partners.h"

namespace facet {
namespace {

constexpr double kLeastBase = 0.05;     // of the median depth,
constexpr double kMostBase = 0.5;       // beyond which too much looks different;
constexpr double kFarther = 2.0;        // and how much farther away the next one is
constexpr double kLeastOverlap = 0.85;  // cosine of the angle between the views

}  // namespace

FixedVector<std::size_t, kPartners> choose_partners(std::span<const Se3> T_own_others, double depth_m) {
    FixedVector<std::size_t, kPartners> chosen;
    double least = kLeastBase * depth_m;
    for (std::size_t i = 0; i < T_own_others.size() && chosen.size() < kPartners; ++i) {
        const double base = T_own_others[i].p.norm();
        const double cosine = (T_own_others[i].q * Eigen::Vector3d::UnitZ()).z();
        if (base > least && base < kMostBase * depth_m && cosine > kLeastOverlap) {
            chosen.push_back(i);
            least = kFarther * base;
        }
    }
    return chosen;
}

}  // namespace facet
