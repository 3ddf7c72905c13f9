// SPDX-License-Identifier: BSD-2-Clause
// SPI through the kernel's spidev.
#pragma once

#include <string>

#include "drivers/imu_spi/spi_device.h"
#include "platform/port/kernel_io.h"

namespace facet {

/// A device node such as /dev/spidev0.0 (Documentation/spi/spidev.rst). Thread-bound.
class Spidev final : public SpiDevice {
public:
    static constexpr std::size_t kMaxSegments = 8;

    Spidev(KernelIo& io, std::string path) : io_(io), path_(std::move(path)) {}
    ~Spidev() override { Spidev::close(); }
    Spidev(const Spidev&) = delete;
    Spidev& operator=(const Spidev&) = delete;

    Status open(const SpiSettings& settings) override;
    void close() override;
    Status transfer(std::span<const SpiSegment> segments) override;
    std::string_view problem() const override { return problem_; }

private:
    Status fail(const char* what, int result);

    KernelIo& io_;
    std::string path_;
    std::string problem_;
    int fd_ = -1;
};

}  // namespace facet
