// SPDX-License-Identifier: BSD-2-Clause
// Whether the system grants the cores, priorities and memory that a vehicle file asks for.
#pragma once

#include "app/config/vehicle.h"
#include "app/run/dry_run.h"

namespace facet {

/// SCHED_FIFO priority that the kernel gives to threads of interrupts, those that count a line's edges among them.
inline constexpr int kInterruptPriority = 50;

/// One line of a dry run. Locks this process' memory if that is asked for. Heap, threads while it runs.
ProbeLine probe_system(const VehicleRealtime& wanted);

}  // namespace facet
