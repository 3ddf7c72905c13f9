// SPDX-License-Identifier: BSD-2-Clause
// A range finder that looks down.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "app/lab/sim/imu_synthesis.h"
#include "app/lab/sim/scene.h"
#include "platform/base/range_sample.h"
#include "platform/base/status.h"

namespace facet::sim {

/// Readings, 50 a second, along the axis of the body that points down at the start: the nearest surface on it, with
/// white noise. None where it is farther than 8 m or nearer than 5 cm. The sensor is at the IMU. Heap.
std::vector<RangeSample> find_ranges(const Scene& scene, std::span<const ImuRecord> imu, double sigma_m,
                                     std::uint64_t seed);

/// Writes them as a replay reads them; makes the folder. @return kIo
Status write_ranges(const std::string& path, std::span<const RangeSample> ranges);

}  // namespace facet::sim
