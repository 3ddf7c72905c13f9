// SPDX-License-Identifier: BSD-2-Clause
// Chips made of a register file, and data-ready edges that make them sample.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <vector>

#include "drivers/imu_spi/spi_device.h"
#include "tests/support/scripted_source.h"

namespace facet::test {

/// Cuts transactions into frames (chip-select low to high) and hands each to the chip.
class FakeSpiChip : public SpiDevice {
public:
    bool present = true;
    bool is_unbound = false;  ///< its driver has gone: ENODEV
    bool is_open = false;
    int frames = 0;
    SpiSettings settings;

    Status open(const SpiSettings& wanted) override {
        settings = wanted;
        is_open = present;
        return present ? Status::kOk : Status::kNotFound;
    }
    void close() override { is_open = false; }
    Status transfer(std::span<const SpiSegment> segments) override {
        if (!present || !is_open) {
            return Status::kIo;
        }
        if (is_unbound) {
            return Status::kNotFound;
        }
        for (std::size_t i = 0; i < segments.size();) {
            const std::size_t first = i;
            std::vector<std::uint8_t> out;
            do {
                const SpiSegment& s = segments[i];
                out.insert(out.end(), s.size, 0);
                if (s.out != nullptr) {
                    std::copy_n(s.out, s.size, out.end() - static_cast<std::ptrdiff_t>(s.size));
                }
            } while (!segments[i++].release && i < segments.size());
            std::vector<std::uint8_t> in(out.size(), 0);
            ++frames;
            frame(out, in);
            std::size_t at = 0;
            for (std::size_t k = first; k < i; ++k) {
                if (segments[k].in != nullptr) {
                    std::copy_n(in.begin() + static_cast<std::ptrdiff_t>(at), segments[k].size, segments[k].in);
                }
                at += segments[k].size;
            }
        }
        return Status::kOk;
    }
    std::string_view problem() const override { return present && !is_unbound ? "" : "spi0.0: transfer failed"; }

protected:
    virtual void frame(const std::vector<std::uint8_t>& out, std::vector<std::uint8_t>& in) = 0;
};

/// Edges that a test offers; each makes the chips sample at the moment it is taken. `one_by_one` answers "none" after
/// each edge, so that even a driver that wants only the newest edge gets every one.
class LazyEdges final : public TriggerSource {
public:
    explicit LazyEdges(ManualClock& clock) : clock_(clock) {}

    std::function<void(Timestamp)> on_edge;
    std::int64_t period_ns = 5'000'000;
    bool one_by_one = true;
    int waiting = 0;
    ClockDomain domain = ClockDomain::kMonotonic;
    Duration offset;  ///< of the stamps' clock from the monotonic one

    Status start() override { return Status::kOk; }
    void stop() override {}
    ClockDomain clock() const override { return domain; }
    SourceCounters counters() const override { return {}; }
    std::string_view problem() const override { return ""; }
    Status next(Duration timeout, TriggerEdge& edge) override {
        if (waiting == 0 || (one_by_one && pause_)) {
            pause_ = false;
            clock_.advance(waiting == 0 ? timeout : Duration{});
            return Status::kNotReady;
        }
        --waiting;
        pause_ = true;
        clock_.advance({period_ns});
        edge = {clock_.now() + offset, ++sequence_, true};
        if (on_edge) {
            on_edge(edge.stamp);
        }
        return Status::kOk;
    }
    /// Edges that the kernel lost.
    void lose(std::uint32_t edges) {
        sequence_ += edges;
        clock_.advance({period_ns * static_cast<std::int64_t>(edges)});
    }

private:
    ManualClock& clock_;
    std::uint32_t sequence_ = 0;
    bool pause_ = false;
};

/// Registers of one byte, read with the top bit of the address set.
class ByteRegisterChip : public FakeSpiChip {
public:
    explicit ByteRegisterChip(std::size_t dummy_bytes = 0) : dummy_bytes_(dummy_bytes) {}

    std::array<std::array<std::uint8_t, 128>, 8> banks{};
    std::array<std::uint8_t, 128>& registers() { return banks[bank_]; }

protected:
    virtual void on_write(std::uint8_t, std::uint8_t) {}
    virtual std::uint8_t on_read(std::uint8_t address, std::size_t index) {
        return registers()[(address + index) & 0x7F];
    }
    void select_bank(std::uint8_t bank) { bank_ = bank % 8; }

    void frame(const std::vector<std::uint8_t>& out, std::vector<std::uint8_t>& in) override {
        const std::uint8_t address = out[0] & 0x7F;
        if ((out[0] & 0x80) == 0) {
            registers()[address] = out[1];
            on_write(address, out[1]);
            return;
        }
        for (std::size_t i = 1 + dummy_bytes_; i < out.size(); ++i) {
            in[i] = on_read(address, i - 1 - dummy_bytes_);
        }
    }

private:
    std::size_t dummy_bytes_;
    std::size_t bank_ = 0;
};

}  // namespace facet::test
