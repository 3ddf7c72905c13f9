// SPDX-License-Identifier: BSD-2-Clause
// Which other files a vehicle file needs beside it.
#pragma once

#include <string>
#include <vector>

namespace facet {

/// The files that a vehicle file names, as it names them: calibration, parameters, CAN database, signing key. They need
/// not be there. Throws InputError if the vehicle file cannot be read. Reentrant; heap.
std::vector<std::string> files_named_by(const std::string& vehicle_file);

}  // namespace facet
