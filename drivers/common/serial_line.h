// SPDX-License-Identifier: BSD-2-Clause
// Opens serial lines.
#pragma once

#include <string>

#include "platform/base/status.h"
#include "platform/port/kernel_io.h"

namespace facet {

/// Opens a line raw, 8N1, without flow control, at any speed; it never blocks. Adapters on USB are asked not to collect
/// bytes, which may be refused. Reentrant. Heap for the words of a problem.
/// @param fd  the caller's to close, on success
/// @param problem  set on failure, with the device's name
/// @return kNotFound if there is no such device, kInvalidArgument if it is no serial line, kIo if the system refuses
Status open_serial_line(KernelIo& io, const std::string& device, int baud, int& fd, std::string& problem);

}  // namespace facet
