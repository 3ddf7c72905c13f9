// SPDX-License-Identifier: BSD-2-Clause
// Points in time and spans of time as 64-bit nanoseconds; the only clock type of estimator and mesh.
#pragma once

#include <compare>
#include <cstdint>

namespace facet {

/// A span of time, integer nanoseconds. Reentrant. No heap.
struct Duration {
    std::int64_t ns = 0;

    /// Nearest nanosecond to a span in seconds; |s| must stay below 292 years.
    static constexpr Duration from_seconds(double s) {
        return {static_cast<std::int64_t>(s * 1e9 + (s < 0.0 ? -0.5 : 0.5))};
    }
    constexpr double seconds() const { return static_cast<double>(ns) * 1e-9; }

    constexpr auto operator<=>(const Duration&) const = default;
    constexpr Duration operator+(Duration o) const { return {ns + o.ns}; }
    constexpr Duration operator-(Duration o) const { return {ns - o.ns}; }
    constexpr Duration operator-() const { return {-ns}; }
};

/// A point in time, integer nanoseconds since the epoch of the log or clock it came from. Two stamps are comparable
/// only if they come from one clock: the synchroniser maps all sensors onto one. Reentrant. No heap.
struct Timestamp {
    std::int64_t ns = 0;

    constexpr double seconds() const { return static_cast<double>(ns) * 1e-9; }

    constexpr auto operator<=>(const Timestamp&) const = default;
    constexpr Timestamp operator+(Duration d) const { return {ns + d.ns}; }
    constexpr Timestamp operator-(Duration d) const { return {ns - d.ns}; }
    constexpr Duration operator-(Timestamp o) const { return {ns - o.ns}; }
};

}  // namespace facet
