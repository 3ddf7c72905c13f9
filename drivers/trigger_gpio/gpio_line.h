// SPDX-License-Identifier: BSD-2-Clause
// One line of a GPIO chip, whichever way the kernel is asked for it.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "platform/base/status.h"
#include "platform/port/clock.h"
#include "platform/port/kernel_io.h"

namespace facet {

enum class GpioBackend : std::uint8_t {
    kAuto,      ///< the library where it numbers edges (2.x), else the character device, which needs Linux 5.10
    kLibgpiod,  ///< the library, 1.6 or 2.x: whichever the program was compiled with
    kChardev    ///< the kernel's character device (v2) itself
};

struct GpioLineName {
    std::string chip = "/dev/gpiochip0";
    int offset = -1;   ///< on the chip; -1: find it by name
    std::string name;  ///< as the device tree or gpioinfo has it
    GpioBackend backend = GpioBackend::kAuto;
};

struct GpioInputSettings {
    bool rising = true;
    bool falling = false;
    bool pull_up = false;
    ClockDomain clock =
        ClockDomain::kMonotonic;    ///< kMonotonic, kRealtime, or kHardware (a hardware timestamping engine)
    std::uint32_t debounce_us = 0;  ///< 0: none, which keeps the hardware interrupt's stamp
};

/// An edge as the kernel reports it.
struct GpioEvent {
    std::int64_t stamp_ns = 0;
    std::uint32_t sequence = 0;  ///< from 1 when the line is requested; 0: the edges are not numbered
    bool rising = true;
};

/// Owns a requested line. Implementations are held to the same tests (tests/drivers/trigger_gpio). Thread-bound. Heap
/// in open_input(), open_output() and on failure only.
class GpioLine {
public:
    static constexpr std::size_t kEventsPerRead = 16;
    static constexpr std::uint32_t kEventsInKernel = 64;  ///< asked for, where the kernel lets choose

    GpioLine() = default;
    virtual ~GpioLine() = default;
    GpioLine(const GpioLine&) = delete;
    GpioLine& operator=(const GpioLine&) = delete;

    /// Closes what was open.
    /// @param problem  set on failure
    /// @return kNotFound if there is no such chip or line, kInvalidArgument if this backend cannot serve the settings,
    ///         kIo otherwise (line in use, no permission, clock not available)
    virtual Status open_input(const GpioLineName& name, const GpioInputSettings& settings, std::string& problem) = 0;
    /// As an output, low.
    virtual Status open_output(const GpioLineName& name, std::string& problem) = 0;
    virtual Status set(bool high, std::string& problem) = 0;
    /// Reads edges that wait. Blocks if there are none: wait for fd() to be readable first.
    /// @return how many, or -errno
    virtual int read(std::span<GpioEvent, kEventsPerRead> events) = 0;
    virtual void close() = 0;
    virtual bool is_open() const = 0;
    /// Readable when edges wait; negative if closed.
    virtual int fd() const = 0;
};

/// @param io  for the character device; borrowed. The library makes its system calls itself.
std::unique_ptr<GpioLine> make_gpio_line(GpioBackend backend, KernelIo& io);

/// For messages: "/dev/gpiochip0 line 17". Reentrant. Heap.
std::string describe(const GpioLineName& name);
/// Sets the problem "LABEL: WHAT: words of the error". @param result  -errno
/// @return kNotFound if the error says that there is no such device, else kIo. Reentrant. Heap.
Status gpio_problem(const std::string& label, const char* what, int result, std::string& problem);
/// Likewise, for a line that was refused: because it is in use, or else. Reentrant. Heap.
Status gpio_refusal(const std::string& label, int result, std::string& problem);

}  // namespace facet
