// SPDX-License-Identifier: BSD-2-Clause
// One line of a GPIO chip, by libgpiod.
#pragma once

#include <memory>
#include <string>

#include "drivers/trigger_gpio/gpio_line.h"

namespace facet {

/// A GpioLine by the library; libgpiod1_line.cpp and libgpiod2_line.cpp implement it for the two generations of its
/// interface, and the build compiles the one that fits the library found.
///   1.6  edges are not numbered, stamped by CLOCK_MONOTONIC only (from Linux 5.7 on), not debounced; the kernel keeps
///        16 of them
///   2.x  as the character device
/// Thread-bound. Heap: see GpioLine.
class LibgpiodLine final : public GpioLine {
public:
    /// Whether the kernel's numbers of edges reach us.
    static const bool kNumbersEdges;

    LibgpiodLine();
    ~LibgpiodLine() override;

    Status open_input(const GpioLineName& name, const GpioInputSettings& settings, std::string& problem) override;
    Status open_output(const GpioLineName& name, std::string& problem) override;
    Status set(bool high, std::string& problem) override;
    int read(std::span<GpioEvent, kEventsPerRead> events) override;
    void close() override;
    bool is_open() const override { return handle_ != nullptr; }
    int fd() const override { return fd_; }

private:
    struct Handle;  ///< what the library returned

    std::unique_ptr<Handle> handle_;
    int fd_ = -1;
    std::string label_;
};

}  // namespace facet
