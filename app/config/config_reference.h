// SPDX-License-Identifier: BSD-2-Clause
// Every key of vehicle files and parameter files, for people.
#pragma once

#include <string>
#include <vector>

namespace facet {

/// Every key of a vehicle file as YAML with its default, and before it a comment with unit, bounds and a sentence.
/// Keys, defaults and bounds are what the reader itself asks for when it is given examples of every kind of sensor and
/// sink; the sentences are those of vehicle_keys.h. A key that another kind of a device has otherwise is a comment.
/// Reentrant. Heap.
std::string vehicle_reference();

/// The same of a file of parameters, from the tables of the configuration's structs. Reentrant. Heap.
std::string parameter_reference();

/// What the table lacks: keys without a sentence, and sentences without a key. Empty if it is complete.
std::vector<std::string> reference_gaps();

}  // namespace facet
