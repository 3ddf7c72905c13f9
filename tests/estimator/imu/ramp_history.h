// SPDX-License-Identifier: BSD-2-Clause
// An inertial history whose readings are known everywhere.
#pragma once

#include <catch2/catch.hpp>
#include <memory>

#include "estimator/imu/imu_buffer.h"

namespace facet::test {

inline constexpr std::int64_t kStep_ns = 5'000'000;

/// Linear in time, so that interpolation and the mean over a step are exact.
inline ImuSample ramp(std::int64_t stamp_ns) {
    const double t = static_cast<double>(stamp_ns) * 1e-9;
    return {Timestamp{stamp_ns}, {0.5 * t, 0.2 - t, 0.3}, {1.0 + t, -2.0 * t, 9.81}};
}

/// On the heap: the buffer is too large for a local.
inline std::unique_ptr<ImuBuffer> filled(int samples, std::int64_t first_ns = 0) {
    auto buffer = std::make_unique<ImuBuffer>(200.0);
    for (int k = 0; k < samples; ++k) {
        REQUIRE(ok(buffer->push(ramp(first_ns + k * kStep_ns))));
    }
    return buffer;
}

inline Timestamp ms(double t) { return Timestamp{static_cast<std::int64_t>(t * 1e6)}; }

}  // namespace facet::test
