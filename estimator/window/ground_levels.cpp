// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/ground_levels.h"

namespace facet {
namespace {

constexpr double kGate = 9.0;       // squared, on the change of height between two readings
constexpr double kMaxChi2 = 4.0;    // mean squared residual of a level's readings
constexpr int kJudgedReadings = 5;  // fewer say little of that
// A level that was left so long ago is not known again: by then height may have drifted as far as tables are high.
constexpr double kMemory_s = 10.0;
constexpr double kUnknown_m2 = 1e6;  // variance of a height of which nothing is known

/// Variance of the ground's height after this way over it (m^2).
constexpr double walk(double distance_m) { return RangeConfig::kUnevenness * RangeConfig::kUnevenness * distance_m; }

Eigen::Vector3d met_W(const Keyframe& keyframe) {
    return keyframe.state.p_W_B + keyframe.state.q_W_B * keyframe.ground.p_B;
}

const GroundLevel& level_of(const WindowState& state, int l) { return state.ground[static_cast<std::size_t>(l)]; }

/// Known levels, that read last first, as far as they are remembered. @return how many
int recent_levels(const WindowState& state, Timestamp now, std::array<int, PriorFactor::kMaxGround>& order) {
    int count = 0;
    for (int l = 0; l < PriorFactor::kMaxGround; ++l) {
        if (!level_of(state, l).is_known || (now - level_of(state, l).last).seconds() > kMemory_s) {
            continue;
        }
        int at = count++;
        for (; at > 0 && level_of(state, order[static_cast<std::size_t>(at) - 1]).last < level_of(state, l).last;
             --at) {
            order[static_cast<std::size_t>(at)] = order[static_cast<std::size_t>(at) - 1];
        }
        order[static_cast<std::size_t>(at)] = l;
    }
    return count;
}

/// The level that a point is of; GroundReading::kNone: of none that is known.
int find_level(const RangeConfig& config, const WindowState& state, const Eigen::Vector3d& p_W, Timestamp now,
               double climb_sigma_m_per_s) {
    std::array<int, PriorFactor::kMaxGround> order{};
    const int count = recent_levels(state, now, order);
    int found = GroundReading::kNone;
    double least = kGate;
    for (int i = 0; i < count; ++i) {
        const int l = order[static_cast<std::size_t>(i)];
        const GroundLevel& level = level_of(state, l);
        const double climb_m = climb_sigma_m_per_s * (now - level.last).seconds();
        const double variance =
            2.0 * config.sigma_m * config.sigma_m + climb_m * climb_m + walk((p_W.head<2>() - level.place_m).norm());
        const double change_m = p_W.z() - level.height_m;
        const double squared = change_m * change_m / variance;
        if (squared < least) {
            least = i == 0 ? 0.0 : squared;  // the one read last goes on wherever it can
            found = l;
        }
    }
    return found;
}

/// Nothing is known of a level any more, by the prior or by readings.
void forget(int l, int row, WindowState& state) {
    for (Keyframe& keyframe : state.keyframes) {
        if (keyframe.ground.level == l) {
            keyframe.ground.level = GroundReading::kNone;
        }
    }
    state.prior.add_walk(row, kUnknown_m2);
    state.ground[static_cast<std::size_t>(l)] = {};
}

/// One that is not known, or else the one read longest ago.
int free_level(const WindowState& state) {
    int free = 0;
    for (int l = 0; l < PriorFactor::kMaxGround; ++l) {
        if (!level_of(state, l).is_known) {
            return l;
        }
        free = level_of(state, l).last < level_of(state, free).last ? l : free;
    }
    return free;
}

/// Begins a level with the newest keyframe's reading.
void begin(int l, int row, WindowState& state) {
    forget(l, row, state);
    Keyframe& keyframe = state.keyframes.back();
    const Eigen::Vector3d p_W = met_W(keyframe);
    keyframe.ground.level = l;
    state.ground[static_cast<std::size_t>(l)] = {true, p_W.z(), p_W.z(), keyframe.stamp, p_W.head<2>()};
}

}  // namespace

void add_ground_reading(const RangeConfig& config, int first_row, const Eigen::Vector3d& p_B,
                        double climb_sigma_m_per_s, WindowState& state) {
    Keyframe& keyframe = state.keyframes.back();
    keyframe.ground.p_B = p_B;
    const Eigen::Vector3d p_W = met_W(keyframe);
    const int l = find_level(config, state, p_W, keyframe.stamp, climb_sigma_m_per_s);
    if (l == GroundReading::kNone) {
        const int free = free_level(state);
        begin(free, first_row + free, state);
        return;
    }
    GroundLevel& level = state.ground[static_cast<std::size_t>(l)];
    state.prior.add_walk(first_row + l, walk((p_W.head<2>() - level.place_m).norm()));
    level.last = keyframe.stamp;
    level.place_m = p_W.head<2>();
    keyframe.ground.level = l;
}

bool drop_uneven_ground(const RangeConfig& config, int first_row, WindowState& state) {
    const int l = state.keyframes.back().ground.level;
    if (l == GroundReading::kNone) {
        return false;
    }
    int count = 0;
    double sum = 0.0;
    for (const Keyframe& keyframe : state.keyframes) {
        if (keyframe.ground.level == l) {
            const double residual = (met_W(keyframe).z() - level_of(state, l).height_m) / config.sigma_m;
            sum += residual * residual;
            ++count;
        }
    }
    if (count < kJudgedReadings || sum < kMaxChi2 * count) {
        return false;
    }
    forget(l, first_row + l, state);
    return true;
}

}  // namespace facet
