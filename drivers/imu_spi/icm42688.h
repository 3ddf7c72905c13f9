// SPDX-License-Identifier: BSD-2-Clause
// TDK InvenSense ICM-42688-P through its FIFO.
#pragma once

#include <cstdint>
#include <span>

#include "drivers/imu_spi/register_bus.h"
#include "drivers/imu_spi/spi_imu_chip.h"
#include "platform/base/result.h"
#include "platform/port/clock.h"

namespace facet {

/// One FIFO packet of 20 bytes (high resolution), as numbers.
struct IcmPacket {
    static constexpr std::size_t kSize = 20;

    bool empty = false;                               ///< the FIFO had nothing (more)
    Eigen::Vector3d rate = Eigen::Vector3d::Zero();   ///< (rad/s)
    Eigen::Vector3d force = Eigen::Vector3d::Zero();  ///< (m/s^2)
    double temperature_c = 0.0;
    std::uint16_t time = 0;  ///< microseconds, wraps
};

/// Parses a packet: header; force and rate bits [19:4], big-endian; temperature (16 bits, 132.48 LSB/K, 0 at 25 deg C);
/// time; for each axis a byte with force and rate bits [3:0]. In this format 2^19 is always 16 g and 2000 deg/s.
/// @return kCorrupt if the header is not that of such a packet, or a value is the chip's mark for "invalid"
Result<IcmPacket> parse_icm_packet(std::span<const std::uint8_t, IcmPacket::kSize> bytes);

struct Icm42688Options {
    std::uint16_t rate_hz = 1000;  ///< 200, 500, 1000 or 2000
    std::uint8_t watermark = 1;    ///< packets for one data-ready edge, 1 to 50
    bool self_test = true;
};

/// Reads the FIFO after each watermark edge. The packet that reached the watermark was written at the edge; the others
/// are placed around it by the chip's microseconds, stretched by the measured ratio of host clock to chip clock (whose
/// oscillator is good to a few percent only). Packets lost to a full FIFO show as gaps of the chip's time.
/// Thread-bound.
class Icm42688 final : public SpiImuChip {
public:
    Icm42688(SpiDevice& bus, Clock& clock, const Icm42688Options& options)
        : bus_(bus), clock_(clock), options_(options) {}

    Status configure(SelfTest test, std::string& problem) override;
    void close() override { bus_.device().close(); }
    Status read(const TriggerEdge& edge, SpiMeasurements& out) override;
    bool newest_edge_only() const override { return false; }
    std::string_view problem() const override { return bus_.device().problem(); }

private:
    static constexpr std::size_t kMaxPackets = 100;

    Status reset_and_identify(std::string& problem);
    Status average(Eigen::Vector3d& rate, Eigen::Vector3d& force);
    Status self_test(std::string& problem);
    Status set_up(std::string& problem);
    Status flush();
    double nominal_us() const { return 1e6 / options_.rate_hz; }
    std::size_t packet_at(const TriggerEdge& edge, std::span<const std::int64_t> times_us);
    void follow_clock(const TriggerEdge& edge, std::int64_t time_us);

    RegisterBus bus_;
    Clock& clock_;
    Icm42688Options options_;
    double ratio_ = 1.0;  ///< host seconds per chip second, filtered
    bool any_edge_ = false;
    Timestamp edge_stamp_;
    std::int64_t edge_time_us_ = 0;
    int merged_in_a_row_ = 0;  ///< of those that an edge without a packet speaks against
    bool any_empty_ = false;   ///< an edge without a packet since the last packets
    bool any_packet_ = false;
    std::int64_t time_us_ = 0;  ///< of the last packet, unwrapped
};

}  // namespace facet
