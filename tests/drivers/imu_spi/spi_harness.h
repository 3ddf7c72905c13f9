// SPDX-License-Identifier: BSD-2-Clause
// An inertial source on a fake chip, for the conformance suite.
#pragma once

#include <memory>

#include "drivers/imu_spi/imu_spi.h"
#include "tests/drivers/imu_spi/fake_spi.h"
#include "tests/port_conformance/source_conformance.h"

namespace facet::test {

/// Derived classes own the chip and set edges.on_edge, breaker and corrupter.
class SpiHarness : public ImuHarness {
public:
    ImuSource& source() override { return *imu; }
    void offer(int count) override { edges.waiting += count; }
    Hook offer_corrupt() override {
        corrupt_next = true;
        offer(1);
        return Hook::kDone;
    }
    Hook offer_ahead() override { return Hook::kCannot; }  // stamps are those of the data-ready line
    Hook break_device() override {
        set_present(false);
        offer(1);
        return Hook::kDone;
    }
    Hook judges_silence() override { return Hook::kDone; }
    Hook end() override { return Hook::kCannot; }
    int held_back() const override { return 0; }
    void repair_device() override { set_present(true); }
    void pass_time() override { clock.advance(Duration::from_seconds(0.6)); }
    virtual void set_present(bool present) = 0;

    static constexpr Duration kSilence = Duration::from_seconds(1.0);
    static ImuSpiOptions judged_options() {
        ImuSpiOptions options;
        options.silence = kSilence;
        return options;
    }

    ManualClock clock{{1'000'000'000}};
    LazyEdges edges{clock};
    bool corrupt_next = false;
    std::unique_ptr<ImuSpi> imu;
};

}  // namespace facet::test
