// SPDX-License-Identifier: BSD-2-Clause
// One frame of a CAN bus as the driver sees it.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "platform/base/timestamp.h"

namespace facet {

/// Frames that the kernel's filter passes: (id & mask) == (value & mask), extended or not.
struct CanFilter {
    std::uint32_t value = 0;
    std::uint32_t mask = 0;
    bool extended = false;
};

struct CanFrame {
    std::uint32_t id = 0;   ///< 11 or 29 bits; of an error frame its class bits (linux/can/error.h)
    bool extended = false;  ///< 29-bit identifier
    bool error = false;     ///< made by the controller, not by a node
    bool fd = false;
    bool bit_rate_switch = false;  ///< of an FD frame that is sent: its data at the faster rate
    std::uint8_t length = 0;       ///< bytes, 0 to 64
    std::array<std::uint8_t, 64> bytes{};
    Timestamp stamp;  ///< of reception

    std::span<const std::uint8_t> data() const { return std::span(bytes).first(length); }
};

}  // namespace facet
