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
constexpr float kSlack = 1e-3F;        // m: the bounds are floats
constexpr float kSectorSlack = 0.05F;  // sectors: the arc tangent below is good to 0.003
constexpr double kMinTurn = 1e-9;      // m^4: rounding does not make a side turn away

/// Arc tangent of y / x in turns of (-0.5, 0.5], to 5e-5, by a polynomial on [0, 1] [Abramowitz64, 4.4.49] and
/// reflections; no branches, so that the loop over faces is vectorized.
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
    std::array<Eigen::Vector2d, kSweepSectors + 1> edge;  ///< unit direction where each sector begins; the first again
    std::array<double, std::size_t{2} * kSweepSectors> range2{};  ///< squared, the round twice: spans need no wrapping
    float start_turns = 0.0F;

    static double cross(const Eigen::Vector2d& u, const Eigen::Vector2d& v) { return u.x() * v.y() - u.y() * v.x(); }

    /// By the approximate arc tangent, then corrected by the exact edges.
    int sector_of(const Eigen::Vector2d& p) const {
        const float t = (turns(static_cast<float>(p.y()), static_cast<float>(p.x())) - start_turns) * kSweepSectors;
        const float wrapped = t - kSweepSectors * std::floor(t / kSweepSectors);
        const int sector = std::min(static_cast<int>(wrapped), kSweepSectors - 1);
        if (cross(edge[static_cast<std::size_t>(sector)], p) < 0.0) {
            return sector == 0 ? kSweepSectors - 1 : sector - 1;
        }
        if (cross(edge[static_cast<std::size_t>(sector) + 1], p) >= 0.0) {
            return sector + 1 == kSweepSectors ? 0 : sector + 1;
        }
        return sector;
    }

    void lower(int sector, double squared) {
        const auto s = static_cast<std::size_t>(sector);
        range2[s] = range2[s + kSweepSectors] = std::min(range2[s], squared);
    }

    double farthest2() const { return *std::max_element(range2.begin(), range2.begin() + kSweepSectors); }

    /// Whether any sector of first..last (first < kSweepSectors, less than one round) is still open at this distance.
    bool may_help(int first, int last, float bound) const {
        const double bound2 = static_cast<double>(bound) * static_cast<double>(bound);
        bool open = false;
        for (int s = first; s <= last; ++s) {
            open = open || range2[static_cast<std::size_t>(s)] > bound2;
        }
        return open;
    }

    /// Nearest point of the segment in each sector it passes, counterclockwise from a to b (less than half a turn).
    void add_segment(const Eigen::Vector2d& a, int first, const Eigen::Vector2d& b, int last) {
        const int passed = last >= first ? last - first : last - first + kSweepSectors;
        if (passed > kSweepSectors / 2 + 1) {  // a and b on one ray, rounding put them across its sector's edge
            lower(first, a.squaredNorm());
            lower(last, b.squaredNorm());
            return;
        }
        const Eigen::Vector2d d = b - a;
        const double length2 = d.squaredNorm();
        const double foot = length2 > 0.0 ? -a.dot(d) / length2 : 0.0;
        double t = 0.0;
        for (int k = 0; k <= passed; ++k) {
            const int sector = first + k < kSweepSectors ? first + k : first + k - kSweepSectors;
            double end = 1.0;
            if (k < passed) {  // leaves through the next sector's edge e: cross(e, a + t d) = 0
                const Eigen::Vector2d& e = edge[static_cast<std::size_t>(sector) + 1];
                const double slope = cross(e, d);
                end = slope != 0.0 ? std::clamp(-cross(e, a) / slope, t, 1.0) : t;
            }
            lower(sector, (a + std::clamp(foot, t, end) * d).squaredNorm());
            t = end;
        }
    }
};

/// Bounds of all faces: distance from below, and sectors from outside.
void RangeQuery::bound_for_sweep(const SweepRequest& request, float start_turns) {
    const Eigen::Vector3f q = (request.p_W - middle_).cast<float>();
    const float low = q.z() - static_cast<float>(request.below_m);
    const float high = q.z() + static_cast<float>(request.above_m);
    const auto range = static_cast<float>(request.max_range_m);
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
        const float middle = (turns(dy, dx) - start_turns) * kSweepSectors;
        // asin(x) <= pi/2 x; a sphere around the vehicle is in all sectors.
        const float half = bound > 0.0F ? 0.25F * kSweepSectors * (r / distance) + kSectorSlack : 0.5F * kSweepSectors;
        const float first = std::floor(middle - half);
        const float round = kSweepSectors * std::floor(first * (1.0F / kSweepSectors));
        first_sector_[i] = static_cast<std::int32_t>(first - round);
        last_sector_[i] = static_cast<std::int32_t>(std::floor(middle + half) - round);
    }
}

/// Faces that bounds do not rule out, nearest first by counting. @return how many
std::size_t RangeQuery::order_for_sweep(double max_range_m) {
    const auto n = static_cast<std::size_t>(count_);
    std::size_t selected = 0;
    for (std::size_t i = 0; i < n; ++i) {
        selected_[selected] = static_cast<std::uint16_t>(i);
        selected += bound_[i] < kNone ? 1 : 0;
    }
    const float per_bucket = static_cast<float>(kBuckets - 1) / static_cast<float>(max_range_m);
    const auto bucket_of = [&](std::uint16_t i) { return static_cast<std::size_t>(bound_[i] * per_bucket); };
    std::array<std::uint16_t, kBuckets + 1> begin{};
    for (std::size_t j = 0; j < selected; ++j) {
        ++begin[bucket_of(selected_[j]) + 1];
    }
    for (std::size_t b = 1; b <= kBuckets; ++b) {
        begin[b] = static_cast<std::uint16_t>(begin[b] + begin[b - 1]);
    }
    for (std::size_t j = 0; j < selected; ++j) {
        order_[begin[bucket_of(selected_[j])]++] = selected_[j];
    }
    return selected;
}

/// Cuts a convex polygon to side * z <= limit. @return number of corners left
std::size_t RangeQuery::cut_at_height(std::array<Eigen::Vector3d, 5>& polygon, std::size_t count, double side,
                                      double limit) {
    std::array<Eigen::Vector3d, 5> kept;
    std::size_t n = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const Eigen::Vector3d& a = polygon[i];
        const Eigen::Vector3d& b = polygon[i + 1 == count ? 0 : i + 1];
        const double da = limit - side * a.z();
        const double db = limit - side * b.z();
        if (da >= 0.0) {
            kept[n++] = a;
        }
        if ((da < 0.0) != (db < 0.0)) {
            kept[n++] = a + (da / (da - db)) * (b - a);
        }
    }
    std::copy_n(kept.begin(), n, polygon.begin());
    return n;
}

/// The triangle's part within the band of heights, seen from above: its sides that face the vehicle, in each sector.
/// Everything behind them is farther away in the same sector.
void RangeQuery::sweep_face(std::size_t face, const Eigen::Vector3d& q, const SweepRequest& request, Sweep& sweep) {
    std::array<Eigen::Vector3d, 5> polygon{corner(face, 0) - q, corner(face, 1) - q, corner(face, 2) - q};
    std::size_t count = 3;
    const auto [low, high] = std::minmax({polygon[0].z(), polygon[1].z(), polygon[2].z()});
    if (high > request.above_m) {
        count = cut_at_height(polygon, count, 1.0, request.above_m);
    }
    if (low < -request.below_m) {
        count = cut_at_height(polygon, count, -1.0, request.below_m);
    }
    std::array<int, 5> sector{};
    std::array<double, 5> turn{};
    double twice_area = 0.0;
    bool left = true;
    bool right = true;
    for (std::size_t i = 0; i < count; ++i) {
        const Eigen::Vector2d a = polygon[i].head<2>();
        turn[i] = Sweep::cross(a, polygon[i + 1 == count ? 0 : i + 1].head<2>());
        sector[i] = sweep.sector_of(a);
        twice_area += turn[i];
        left = left && turn[i] > 0.0;
        right = right && turn[i] < 0.0;
    }
    if (count >= 3 && (left || right)) {  // right above or below the vehicle
        sweep.range2.fill(0.0);
        return;
    }
    for (std::size_t i = 0; i < count; ++i) {
        if (turn[i] * twice_area > kMinTurn) {
            continue;  // turned away
        }
        const std::size_t j = i + 1 == count ? 0 : i + 1;
        if (turn[i] < 0.0) {
            sweep.add_segment(polygon[j].head<2>(), sector[j], polygon[i].head<2>(), sector[i]);
        } else {
            sweep.add_segment(polygon[i].head<2>(), sector[i], polygon[j].head<2>(), sector[j]);
        }
    }
}

void RangeQuery::sweep(const SweepRequest& request, std::span<double, kSweepSectors> range_m) {
    const double start = request.start_rad * 0.5 / std::numbers::pi;
    Sweep sweep{.edge = {}, .range2 = {}, .start_turns = static_cast<float>(start - std::floor(start))};
    sweep.range2.fill(request.max_range_m * request.max_range_m);
    for (int k = 0; k < kSweepSectors; ++k) {
        const double angle = request.start_rad + k * kWidth;
        sweep.edge[static_cast<std::size_t>(k)] = {std::cos(angle), std::sin(angle)};
    }
    sweep.edge.back() = sweep.edge.front();
    bound_for_sweep(request, sweep.start_turns);
    const std::size_t selected = order_for_sweep(request.max_range_m);
    const Eigen::Vector3d q = request.p_W - middle_;
    const auto bucket_m = static_cast<float>(request.max_range_m / (kBuckets - 1));
    float next_look = 0.0F;
    for (std::size_t j = 0; j < selected; ++j) {
        const std::size_t i = order_[j];
        if (bound_[i] > next_look) {  // once per bucket: is any sector open beyond it?
            const float nearer = bound_[i] - bucket_m;
            if (nearer > 0.0F && static_cast<double>(nearer * nearer) > sweep.farthest2()) {
                break;
            }
            next_look = bound_[i] + bucket_m;
        }
        const int last = std::min(last_sector_[i], first_sector_[i] + kSweepSectors - 1);
        if (sweep.may_help(first_sector_[i], last, bound_[i])) {
            sweep_face(i, q, request, sweep);
        }
    }
    for (std::size_t k = 0; k < range_m.size(); ++k) {
        range_m[k] = std::sqrt(sweep.range2[k]);
    }
}

}  // namespace facet
