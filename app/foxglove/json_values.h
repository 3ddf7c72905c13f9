// SPDX-License-Identifier: BSD-2-Clause
// Values that many messages contain, as JSON.
#pragma once

#include <algorithm>
#include <nlohmann/json.hpp>

#include "estimator/geometry/se3.h"
#include "platform/base/timestamp.h"

/// Reentrant. Heap.
namespace facet::json_values {

using Json = nlohmann::ordered_json;

/// Zero before the epoch.
inline Json stamp(Timestamp stamp) {
    constexpr std::int64_t kNsPerS = 1'000'000'000;
    const std::int64_t ns = std::max<std::int64_t>(stamp.ns, 0);
    return {{"sec", ns / kNsPerS}, {"nsec", ns % kNsPerS}};
}

inline Json vector(const Eigen::Vector3d& v) { return {{"x", v.x()}, {"y", v.y()}, {"z", v.z()}}; }

inline Json quaternion(const Eigen::Quaterniond& q) { return {{"x", q.x()}, {"y", q.y()}, {"z", q.z()}, {"w", q.w()}}; }

inline Json pose(const Se3& T) { return {{"position", vector(T.p)}, {"orientation", quaternion(T.q)}}; }

}  // namespace facet::json_values
