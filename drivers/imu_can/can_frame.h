// SPDX-License-Identifier: BSD-2-Clause
// One frame of a CAN bus as the driver sees it.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "platform/base/timestamp.h"

namespace facet {

struct CanFrame {
    std::uint32_t id = 0;   ///< 11 or 29 bits; of an error frame its class bits (linux/can/error.h)
    bool extended = false;  ///< 29-bit identifier
    bool error = false;     ///< made by the controller, not by a node
    bool fd = false;
    std::uint8_t length = 0;  ///< bytes, 0 to 64
    std::array<std::uint8_t, 64> bytes{};
    Timestamp stamp;  ///< of reception

    std::span<const std::uint8_t> data() const { return std::span(bytes).first(length); }
};

}  // namespace facet
