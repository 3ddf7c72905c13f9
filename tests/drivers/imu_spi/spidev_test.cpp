// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/imu_spi/spidev.h"

#include <linux/spi/spidev.h>

#include <array>
#include <catch2/catch.hpp>
#include <cstring>
#include <map>

#include "tests/support/fake_kernel.h"

namespace facet::spidev_test {
namespace {

/// /dev/spidev0.0 with a loop from output to input.
class FakeSpidevKernel final : public test::FakeKernel {
public:
    int transfer_result = 1;  ///< 1: as many bytes as asked
    int opened = 0;
    std::uint8_t mode = 255;
    std::uint32_t speed_hz = 0;
    std::vector<spi_ioc_transfer> last;

    int open(const char* path, int) override {
        ++opened;
        return std::string(path) == "/dev/spidev0.0" ? 5 : -ENOENT;
    }
    int close(int) override { return 0; }
    int ioctl(int fd, unsigned long request, void* argument) override {
        REQUIRE(fd == 5);
        if (request == SPI_IOC_WR_MODE) {
            std::memcpy(&mode, argument, 1);
            return mode <= 3 ? 0 : -EINVAL;
        }
        if (request == SPI_IOC_WR_MAX_SPEED_HZ) {
            std::memcpy(&speed_hz, argument, 4);
            return 0;
        }
        if (request == SPI_IOC_WR_BITS_PER_WORD) {
            return 0;
        }
        REQUIRE((request == SPI_IOC_MESSAGE(1) || request == SPI_IOC_MESSAGE(2)));
        const std::size_t count = request == SPI_IOC_MESSAGE(1) ? 1 : 2;
        last.assign(static_cast<spi_ioc_transfer*>(argument), static_cast<spi_ioc_transfer*>(argument) + count);
        int bytes = 0;
        for (const spi_ioc_transfer& part : last) {
            if (part.tx_buf != 0 && part.rx_buf != 0) {
                std::memcpy(reinterpret_cast<void*>(part.rx_buf), reinterpret_cast<const void*>(part.tx_buf), part.len);
            }
            bytes += static_cast<int>(part.len);
        }
        return transfer_result == 1 ? bytes : transfer_result;
    }
};

TEST_CASE("segments become one spidev message") {
    FakeSpidevKernel kernel;
    Spidev spi(kernel, "/dev/spidev0.0");
    REQUIRE(ok(spi.open({3, 1'000'000})));
    REQUIRE(ok(spi.open({3, 1'000'000})));
    CHECK(kernel.opened == 1);
    CHECK(kernel.mode == 3);
    CHECK(kernel.speed_hz == 1'000'000);
    const std::array<std::uint8_t, 2> out{0x12, 0x34};
    std::array<std::uint8_t, 2> in{};
    const std::array<SpiSegment, 2> segments{{{out.data(), nullptr, 2, 9, true}, {out.data(), in.data(), 2, 4, true}}};
    REQUIRE(ok(spi.transfer(segments)));
    CHECK(in == out);
    REQUIRE(kernel.last.size() == 2);
    CHECK(kernel.last[0].cs_change == 1);
    CHECK(kernel.last[0].delay_usecs == 9);
    CHECK(kernel.last[1].cs_change == 0);  // never on the last one
}

TEST_CASE("spidev failures have words") {
    FakeSpidevKernel kernel;
    Spidev missing(kernel, "/dev/spidev1.0");
    CHECK(missing.open({0, 1}) == Status::kNotFound);
    CHECK(missing.problem() == "/dev/spidev1.0: cannot be opened: No such file or directory");
    Spidev spi(kernel, "/dev/spidev0.0");
    CHECK(spi.open({9, 1}) == Status::kIo);
    CHECK(spi.problem() == "/dev/spidev0.0: mode or speed refused: Invalid argument");
    std::array<std::uint8_t, 2> in{};
    const SpiSegment segment{nullptr, in.data(), 2, 0, false};
    CHECK(spi.transfer(std::span(&segment, 1)) == Status::kIo);
    REQUIRE(ok(spi.open({0, 1})));
    kernel.transfer_result = -EIO;
    CHECK(spi.transfer(std::span(&segment, 1)) == Status::kIo);
    kernel.transfer_result = 0;
    CHECK(spi.transfer(std::span(&segment, 1)) == Status::kIo);
    CHECK(spi.problem() == "/dev/spidev0.0: transfer cut short: Input/output error");
}

}  // namespace
}  // namespace facet::spidev_test
