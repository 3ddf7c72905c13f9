// SPDX-License-Identifier: BSD-2-Clause
// Keeps a program's memory in place, so that no page fault delays a thread.
#pragma once

#include <cstddef>
#include <string>

#include "platform/base/status.h"

namespace facet {

/// Brings in and locks all pages that the process has, whether they have been touched or not, and locks every later one
/// when it is first touched (mlockall with MCL_ONFAULT, so that stacks of threads that are started afterwards do not
/// become resident as a whole).
/// @return kIo if the system refuses; `refusal` says why and what to set.
Status lock_memory(std::string& refusal);

/// Touches this much of the calling thread's stack below where it is. No heap.
void prefault_stack(std::size_t bytes);

}  // namespace facet
