// SPDX-License-Identifier: BSD-2-Clause
// The option --mavlink.
#pragma once

#include <memory>
#include <string>

#include "drivers/mavlink/mavlink_link.h"

namespace facet {

/// Opens "udp:HOST:PORT" or "serial:DEVICE[:BAUD]" with the stamps of what it is given; nullptr for an empty text.
/// Kernel and clock are borrowed. Throws InputError.
std::unique_ptr<MavlinkLink> open_mavlink(const std::string& text, KernelIo& io, const Clock& clock);

}  // namespace facet
