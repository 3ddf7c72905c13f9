// SPDX-License-Identifier: BSD-2-Clause
// The sweep of RangeQuery.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "mesh/range_query.h"

namespace facet {
namespace {

constexpr double kWidth = 2.0 * std::numbers::pi / kSweepSectors;
constexpr float kNone = 1e30F;
constexpr std::size_t kBuckets = 256;  ///< of the order by distance
constexpr float kSlack = 1e-3F;        // m: bounds are floats
constexpr float kSectorSlack = 0.05F;  // sectors: the arc tangent below is good to 0.003

/// Arc tangent of y / x in turns of (-0.5, 0.5], to 5e-5: a polynomial on [0, 1] and reflections; no branches, so that the
/// loop over faces becomes vector instructions. [Abramowitz64, 4.4.49]
inline float turns(float y, float x) {
    const float ax = std::abs(x);
    const float ay = std::abs(y);
    const float low = ax < ay ? ax : ay;
    const float high = ax < ay ? ay : ax;
    const float a = low / (high + 1e-30F);
    const float s = a * a;
    float r = a * (0.9998660F + s * (-0.3302995F + s * (0.1801410F + s * (-0.0851330F + s * 0.0208351F))));
    r *= 0.15915494F;
    r = ay > ax ? 0.25F - r : r;
    r = x < 0.0F ? 0.5F - r : r;
    return y < 0.0F ? -r : r;
}

}  // namespace

/// One sweep: exact edges of the sectors and the best so far.
struct RangeQuery::Sweep {
    std::array<Eigen::Vector2d, kSweepSectors> edge;  ///< unit direction where each sector begins
    std::span<double, kSweepSectors> range;
    float start_turns = 0.0F;

    static double cross(const Eigen::Vector2d& u, const Eigen::Vector2d& v) { return u.x() * v.y() - u.y() * v.x(); }
    const Eigen::Vector2d& edge_after(int sector) const {
        return edge[static_cast<std::size_t>(sector + 1 == kSweepSectors ? 0 : sector + 1)];
    }

    /// By the approximate arc tangent, then put right by the exact edges.
    int sector_of(const Eigen::Vector2d& p) const {
        const float t = (turns(static_cast<float>(p.y()), static_cast<float>(p.x())) - start_turns) * kSweepSectors;
        const float wrapped = t - kSweepSectors * std::floor(t / kSweepSectors);
        const int sector = std::min(static_cast<int>(wrapped), kSweepSectors - 1);
        if (cross(edge[static_cast<std::size_t>(sector)], p) < 0.0) {
            return sector == 0 ? kSweepSectors - 1 : sector - 1;
        }
        if (cross(edge_after(sector), p) >= 0.0) {
            return sector + 1 == kSweepSectors ? 0 : sector + 1;
        }
        return sector;
    }

    void lower(int sector, double distance) {
        double& r = range[static_cast<std::size_t>(sector)];
        r = std::min(r, distance);
    }

    /// Nearest point of the segment in each sector it passes, counterclockwise from a to b (less than half a turn).
    void add_segment(const Eigen::Vector2d& a, int first, const Eigen::Vector2d& b, int last) {
        const Eigen::Vector2d d = b - a;
        const double length2 = d.squaredNorm();
        const int passed = last >= first ? last - first : last - first + kSweepSectors;
        if (passed > kSweepSectors / 2 + 1) {  // a and b on one ray, rounding put them across its sector's edge
            lower(first, a.norm());
            lower(last, b.norm());
            return;
        }
        const double foot = length2 > 0.0 ? -a.dot(d) / length2 : 0.0;
        double t = 0.0;
        for (int k = 0; k <= passed; ++k) {
            const int sector = first + k < kSweepSectors ? first + k : first + k - kSweepSectors;
            double end = 1.0;
            if (k < passed) {  // leaves through the next sector's edge e: cross(e, a + t d) = 0
                const Eigen::Vector2d& e = edge_after(sector);
                const double slope = cross(e, d);
                end = slope != 0.0 ? std::clamp(-cross(e, a) / slope, t, 1.0) : t;
            }
            lower(sector, (a + std::clamp(foot, t, end) * d).norm());
            t = end;
        }
    }
};

/// Bounds of all faces: distance from below, and sectors from outside.
void RangeQuery::select_for_sweep(const SweepRequest& request) {
    const Eigen::Vector3f q = (request.p_W - middle_).cast<float>();
    const float low = q.z() - static_cast<float>(request.below_m);
    const float high = q.z() + static_cast<float>(request.above_m);
    const auto range = static_cast<float>(request.max_range_m);
    const auto start = static_cast<float>(request.start_rad * 0.5 / std::numbers::pi);
    const auto n = static_cast<std::size_t>(count_);
    for (std::size_t i = 0; i < n; ++i) {
        const float dx = x_[i] - q.x();
        const float dy = y_[i] - q.y();
        const float r = radius_xy_[i] + kSlack;
        const float distance = std::sqrt(dx * dx + dy * dy);
        const float bound = distance - r;
        // Integers, so that nothing branches and the loop is vectorized.
        const int out = static_cast<int>(high_z_[i] + kSlack < low) | static_cast<int>(low_z_[i] - kSlack > high) |
                        static_cast<int>(bound >= range);
        bound_[i] = out != 0 ? kNone : (bound > 0.0F ? bound : 0.0F);
        const float middle = (turns(dy, dx) - start) * kSweepSectors;
        // asin(x) <= pi/2 x; a sphere around the vehicle is in all sectors.
        const float half = bound > 0.0F ? 0.25F * kSweepSectors * (r / distance) + kSectorSlack : 0.5F * kSweepSectors;
        first_sector_[i] = middle - half;
        last_sector_[i] = middle + half;
    }
}

/// The triangle's part within the band of heights, seen from above: its border in each sector.
void RangeQuery::sweep_face(const std::array<Eigen::Vector3d, 3>& corner, const SweepRequest& request, Sweep& sweep) {
    std::array<Eigen::Vector3d, 5> polygon{corner[0], corner[1], corner[2]};
    std::size_t count = 3;
    for (const double side : {1.0, -1.0}) {  // z <= above, then -z <= below
        const double limit = side > 0.0 ? request.above_m : request.below_m;
        std::array<Eigen::Vector3d, 5> kept;
        std::size_t n = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const Eigen::Vector3d& a = polygon[i];
            const Eigen::Vector3d& b = polygon[(i + 1) % count];
            const double da = limit - side * a.z();
            const double db = limit - side * b.z();
            if (da >= 0.0) {
                kept[n++] = a;
            }
            if ((da < 0.0) != (db < 0.0)) {
                kept[n++] = a + (da / (da - db)) * (b - a);
            }
        }
        polygon = kept;
        count = n;
    }
    std::array<int, 5> sector{};
    for (std::size_t i = 0; i < count; ++i) {
        sector[i] = sweep.sector_of(polygon[i].head<2>());
    }
    bool left = true;
    bool right = true;
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t j = i + 1 == count ? 0 : i + 1;
        const Eigen::Vector2d a = polygon[i].head<2>();
        const Eigen::Vector2d b = polygon[j].head<2>();
        const double turn = Sweep::cross(a, b);
        left = left && turn > 0.0;
        right = right && turn < 0.0;
        if (turn < 0.0) {
            sweep.add_segment(b, sector[j], a, sector[i]);
        } else {
            sweep.add_segment(a, sector[i], b, sector[j]);
        }
    }
    if (count >= 3 && (left || right)) {  // right above or below the vehicle
        std::fill(sweep.range.begin(), sweep.range.end(), 0.0);
    }
}

void RangeQuery::sweep(const SweepRequest& request, std::span<double, kSweepSectors> range_m) {
    std::fill(range_m.begin(), range_m.end(), request.max_range_m);
    Sweep sweep{
        .edge = {}, .range = range_m, .start_turns = static_cast<float>(request.start_rad * 0.5 / std::numbers::pi)};
    for (int k = 0; k < kSweepSectors; ++k) {
        const double angle = request.start_rad + k * kWidth;
        sweep.edge[static_cast<std::size_t>(k)] = {std::cos(angle), std::sin(angle)};
    }
    select_for_sweep(request);
    // Nearest faces first, by counting: then most of the others are ruled out by their bounds.
    const float per_bucket = static_cast<float>(kBuckets - 1) / static_cast<float>(request.max_range_m);
    std::array<std::uint16_t, kBuckets + 1> begin{};
    const auto n = static_cast<std::size_t>(count_);
    for (std::size_t i = 0; i < n; ++i) {
        begin[bound_[i] < kNone ? static_cast<std::size_t>(bound_[i] * per_bucket) + 1 : 0] +=
            bound_[i] < kNone ? 1 : 0;
    }
    for (std::size_t b = 1; b <= kBuckets; ++b) {
        begin[b] = static_cast<std::uint16_t>(begin[b] + begin[b - 1]);
    }
    const std::size_t selected = begin[kBuckets];
    for (std::size_t i = 0; i < n; ++i) {
        if (bound_[i] < kNone) {
            order_[begin[static_cast<std::size_t>(bound_[i] * per_bucket)]++] = static_cast<std::uint16_t>(i);
        }
    }
    const Eigen::Vector3d q = request.p_W - middle_;
    for (std::size_t j = 0; j < selected; ++j) {
        const std::size_t i = order_[j];
        const int first = static_cast<int>(std::floor(first_sector_[i]));
        const int last = std::min(static_cast<int>(std::floor(last_sector_[i])), first + kSweepSectors - 1);
        bool may_help = false;
        for (int s = first; s <= last && !may_help; ++s) {
            const int sector = ((s % kSweepSectors) + kSweepSectors) % kSweepSectors;
            may_help = range_m[static_cast<std::size_t>(sector)] > bound_[i];
        }
        if (may_help) {
            sweep_face({corner(i, 0) - q, corner(i, 1) - q, corner(i, 2) - q}, request, sweep);
        }
    }
}

}  // namespace facet
