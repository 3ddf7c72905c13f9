// SPDX-License-Identifier: BSD-2-Clause
// What was lost on the way, as a message.
#pragma once

#include <span>
#include <string>

#include "app/support/named_counter.h"
#include "platform/base/timestamp.h"

namespace facet {

inline constexpr const char* kDropsTopic = "/drops";
inline constexpr const char* kDropsSchema = "facet.Drops";

/// The schema. Reentrant. Heap.
std::string drops_schema_text();

/// facet.Drops: counts since the start, by name. Reentrant. Heap.
std::string drops_message(Timestamp stamp, std::span<const NamedCounter> counts);

}  // namespace facet
