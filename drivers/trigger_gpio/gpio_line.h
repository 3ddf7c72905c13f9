// SPDX-License-Identifier: BSD-2-Clause
// One line of a GPIO chip, by the kernel's character device (v2).
#pragma once

#include <cstdint>
#include <string>

#include "platform/base/status.h"
#include "platform/port/clock.h"
#include "platform/port/kernel_io.h"

namespace facet {

struct GpioLineName {
    std::string chip = "/dev/gpiochip0";
    int offset = -1;   ///< on the chip; -1: find it by name
    std::string name;  ///< as the device tree or gpioinfo has it
};

struct GpioInputSettings {
    bool rising = true;
    bool falling = false;
    bool pull_up = false;
    ClockDomain clock =
        ClockDomain::kMonotonic;    ///< kMonotonic, kRealtime, or kHardware (a hardware timestamping engine)
    std::uint32_t debounce_us = 0;  ///< 0: none, which keeps the hardware interrupt's stamp
};

/// Owns the descriptor of a requested line (Documentation/userspace-api/gpio/chardev.rst, "v2"). Thread-bound. Heap on
/// failure only.
class GpioLine {
public:
    explicit GpioLine(KernelIo& io) : io_(io) {}
    ~GpioLine() { close(); }
    GpioLine(const GpioLine&) = delete;
    GpioLine& operator=(const GpioLine&) = delete;

    /// @param problem  set on failure
    /// @return kNotFound if there is no such chip or line, kInvalidArgument if edges cannot be stamped by that clock,
    ///         kIo
    ///         otherwise (line in use, no permission, clock not available)
    Status open_input(const GpioLineName& name, const GpioInputSettings& settings, std::string& problem);
    /// As an output, low.
    Status open_output(const GpioLineName& name, std::string& problem);
    Status set(bool high, std::string& problem);
    void close();
    bool is_open() const { return fd_ >= 0; }
    int fd() const { return fd_; }

private:
    Status open(const GpioLineName& name, std::uint64_t flags, std::uint32_t debounce_us, std::string& problem);
    Status find(int chip, const GpioLineName& name, std::uint32_t& offset, std::string& problem);

    KernelIo& io_;
    int fd_ = -1;
    std::string label_;
};

}  // namespace facet
