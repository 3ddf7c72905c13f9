// SPDX-License-Identifier: BSD-2-Clause
// One chip on an SPI bus.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "platform/base/status.h"

namespace facet {

/// One part of a transfer, full duplex. `out` and `in` have `size` bytes or are null (zeros sent, input dropped).
struct SpiSegment {
    const std::uint8_t* out = nullptr;
    std::uint8_t* in = nullptr;
    std::size_t size = 0;
    std::uint16_t delay_us = 0;  ///< after this segment
    bool release = false;        ///< raise the chip-select line between this segment and the next
};

struct SpiSettings {
    std::uint8_t mode = 0;  ///< 0 to 3: clock polarity and phase
    std::uint32_t speed_hz = 1'000'000;
};

/// Thread-bound. No heap in transfer.
class SpiDevice {
public:
    virtual ~SpiDevice() = default;

    /// kOk if open already. @return kNotFound or kIo; problem() has the words.
    virtual Status open(const SpiSettings& settings) = 0;
    virtual void close() = 0;
    /// Runs the segments in order as one transaction. @return kIo on failure: the inputs are undefined.
    virtual Status transfer(std::span<const SpiSegment> segments) = 0;
    virtual std::string_view problem() const = 0;
};

}  // namespace facet
