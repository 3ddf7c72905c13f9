// SPDX-License-Identifier: BSD-2-Clause
// One line of a GPIO chip, by the kernel's character device (v2).
#pragma once

#include <string>

#include "drivers/trigger_gpio/gpio_line.h"

namespace facet {

/// A GpioLine by ioctls (Documentation/userspace-api/gpio/chardev.rst, "v2"): edges are numbered also on systems whose
/// libgpiod does not say the numbers. Thread-bound. Heap: see GpioLine.
class ChardevLine final : public GpioLine {
public:
    /// Borrowed: io.
    explicit ChardevLine(KernelIo& io) : io_(io) {}
    ~ChardevLine() override { release(); }

    Status open_input(const GpioLineName& name, const GpioInputSettings& settings, std::string& problem) override;
    Status open_output(const GpioLineName& name, std::string& problem) override;
    Status set(bool high, std::string& problem) override;
    int read(std::span<GpioEvent, kEventsPerRead> events) override;
    void close() override { release(); }
    bool is_open() const override { return fd_ >= 0; }
    int fd() const override { return fd_; }

private:
    Status open(const GpioLineName& name, std::uint64_t flags, std::uint32_t debounce_us, std::string& problem);
    Status find(int chip, const GpioLineName& name, std::uint32_t& offset, std::string& problem);
    void release();

    KernelIo& io_;
    int fd_ = -1;
    std::string label_;
};

}  // namespace facet
