// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/imu_spi/spidev.h"

#include <fcntl.h>
#include <linux/spi/spidev.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "platform/base/assert.h"

namespace facet {

Status Spidev::fail(const char* what, int result) {
    problem_ = path_ + ": " + what + ": " + std::strerror(-result);
    return result == -ENOENT || result == -ENODEV || result == -ENXIO ? Status::kNotFound : Status::kIo;
}

Status Spidev::open(const SpiSettings& settings) {
    if (fd_ >= 0) {
        return Status::kOk;
    }
    fd_ = io_.open(path_.c_str(), O_RDWR);
    if (fd_ < 0) {
        return fail("cannot be opened", fd_);
    }
    std::uint8_t mode = settings.mode;
    std::uint8_t bits = 8;
    std::uint32_t speed_hz = settings.speed_hz;
    int result = io_.ioctl(fd_, SPI_IOC_WR_MODE, &mode);
    result = result < 0 ? result : io_.ioctl(fd_, SPI_IOC_WR_BITS_PER_WORD, &bits);
    result = result < 0 ? result : io_.ioctl(fd_, SPI_IOC_WR_MAX_SPEED_HZ, &speed_hz);
    if (result < 0) {
        close();
        return fail("mode or speed refused", result);
    }
    return Status::kOk;
}

void Spidev::close() {
    if (fd_ >= 0) {
        (void)io_.close(fd_);
    }
    fd_ = -1;
}

Status Spidev::transfer(std::span<const SpiSegment> segments) {
    FACET_ASSERT(segments.size() <= kMaxSegments);
    if (fd_ < 0) {
        return fail("not open", -EBADF);
    }
    std::array<spi_ioc_transfer, kMaxSegments> parts{};
    std::int64_t bytes = 0;
    for (std::size_t i = 0; i < segments.size(); ++i) {
        const SpiSegment& segment = segments[i];
        parts[i].tx_buf = reinterpret_cast<std::uintptr_t>(segment.out);
        parts[i].rx_buf = reinterpret_cast<std::uintptr_t>(segment.in);
        parts[i].len = static_cast<std::uint32_t>(segment.size);
        parts[i].delay_usecs = segment.delay_us;
        // On the last segment cs_change would mean the opposite: stay selected.
        parts[i].cs_change = segment.release && i + 1 < segments.size() ? 1 : 0;
        bytes += static_cast<std::int64_t>(segment.size);
    }
    // SPI_IOC_MESSAGE(n), which is a macro for constants.
    const unsigned long request =
        _IOC(_IOC_WRITE, SPI_IOC_MAGIC, 0, static_cast<unsigned>(segments.size() * sizeof(spi_ioc_transfer)));
    const int result = io_.ioctl(fd_, request, parts.data());
    if (result < 0) {
        return fail("transfer failed", result);
    }
    return result == bytes ? Status::kOk : fail("transfer cut short", -EIO);
}

}  // namespace facet
