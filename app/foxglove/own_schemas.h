// SPDX-License-Identifier: BSD-2-Clause
// The schemas of the messages that are ours: facet.Health, facet.Calibration, facet.Timing.
#pragma once

#include <nlohmann/json.hpp>

namespace facet {

/// Each is made from the table that its message is made from. Reentrant. Heap.
nlohmann::ordered_json health_schema(const char* title);
nlohmann::ordered_json calibration_schema(const char* title);
nlohmann::ordered_json timing_schema(const char* title);

}  // namespace facet
