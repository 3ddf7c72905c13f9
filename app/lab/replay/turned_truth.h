// SPDX-License-Identifier: BSD-2-Clause
// The ground truth of a log whose images an injected vibration turns.
#pragma once

#include <string>

#include "app/lab/faults/fault_injector.h"

namespace facet {

/// Writes the ground truth of a dataset with its attitudes turned as the injector turns images, in EuRoC's 17 columns
/// (8 if the dataset has no more): what `facet eval --groundtruth` is to be given for such a replay. Does nothing if no
/// image is turned, or if there is no ground truth. Heap. Throws InputError if the table cannot be read or written.
void write_turned_truth(const std::string& dataset, FaultInjector& injector, const std::string& path);

}  // namespace facet
