// SPDX-License-Identifier: BSD-2-Clause
// Chips that answer anything. The first byte chooses the chip; the others are what comes over the bus.
#include <memory>
#include <string>

#include "drivers/imu_spi/adis16.h"
#include "drivers/imu_spi/bmi088.h"
#include "drivers/imu_spi/icm42688.h"
#include "tests/fuzz/fuzz_input.h"

using namespace facet;

namespace {

/// Answers with the fuzzer's bytes, and with silence once they are used up.
class NoisyBus final : public SpiDevice {
public:
    explicit NoisyBus(test::FuzzInput& input) : input_(input) {}
    Status open(const SpiSettings& /*settings*/) override { return Status::kOk; }
    void close() override {}
    Status transfer(std::span<const SpiSegment> segments) override {
        for (const SpiSegment& segment : segments) {
            for (std::size_t i = 0; segment.in != nullptr && i < segment.size; ++i) {
                segment.in[i] = input_.take<std::uint8_t>();
            }
        }
        return Status::kOk;
    }
    std::string_view problem() const override { return "noise"; }

private:
    test::FuzzInput& input_;
};

class JumpingClock final : public Clock {
public:
    Timestamp now() const override { return now_; }
    ClockPair read_pair() const override { return {now_, now_, {}}; }
    void sleep_until(Timestamp until) override { now_ = std::max(now_, until); }

private:
    Timestamp now_;
};

std::unique_ptr<SpiImuChip> chip(int kind, NoisyBus& bus, JumpingClock& clock) {
    switch (kind) {
        case 0: return std::make_unique<Icm42688>(bus, clock, Icm42688Options{});
        case 1: return std::make_unique<Bmi088>(bus, bus, clock, Bmi088Options{});
        default: break;
    }
    Adis16Options options;
    options.model = static_cast<Adis16Model>((kind - 2) % 5);
    return std::make_unique<Adis16>(bus, clock, options);
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    test::FuzzInput input(data, size);
    const auto kind = input.take<std::uint8_t>();
    NoisyBus bus(input);
    JumpingClock clock;
    const auto imu = chip(kind % 7, bus, clock);
    if ((kind & 0x80U) != 0) {  // as it answers when it is set up; else as one that was
        std::string problem;
        test::require(ok(imu->configure(SelfTest::kSkip, problem)) || !problem.empty());
    }
    SpiMeasurements measurements;
    TriggerEdge edge;
    for (int i = 0; i < 16 && !input.empty(); ++i) {
        edge.stamp = edge.stamp + Duration::from_seconds(1e-3);
        ++edge.sequence;
        measurements.clear();
        static_cast<void>(imu->read(edge, measurements));
        for (const SpiMeasurement& m : measurements) {
            test::require(!m.rate.has_value() || m.rate->allFinite());
            test::require(!m.force.has_value() || m.force->allFinite());
        }
    }
    return 0;
}
