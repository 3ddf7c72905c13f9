// SPDX-License-Identifier: BSD-2-Clause
// Frames of a CAN bus, to the protocols that reassemble them. Each frame: identifier, flags and length, bytes.
#include <string>

#include "drivers/imu_can/dronecan.h"
#include "drivers/imu_can/openimu300.h"
#include "tests/fuzz/fuzz_input.h"

using namespace facet;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    test::FuzzInput input(data, size);
    DroneCanDecoder drone_can;
    DbcFile database;
    DbcDecoder open_imu;
    std::string error;
    test::require(ok(database.parse(openimu300_dbc(), "openimu300", error)));
    test::require(ok(open_imu.configure(database, openimu300_map(), error)));
    while (!input.empty()) {
        CanFrame frame;
        const auto id = input.take<std::uint32_t>();
        frame.id = id & 0x1FFFFFFFU;
        frame.extended = (id >> 31U) != 0;
        frame.error = ((id >> 30U) & 1U) != 0;
        frame.length = input.take<std::uint8_t>() % 65U;
        const auto bytes = input.take_bytes(frame.length);
        std::copy(bytes.begin(), bytes.end(), frame.bytes.begin());
        for (CanDecoder* decoder : {static_cast<CanDecoder*>(&drone_can), static_cast<CanDecoder*>(&open_imu)}) {
            CanMeasurement measurement;
            if (ok(decoder->decode(frame, measurement))) {
                test::require(measurement.rate.has_value() || measurement.force.has_value());
                test::require(!measurement.rate.has_value() || measurement.rate->allFinite());
                test::require(!measurement.force.has_value() || measurement.force->allFinite());
            }
        }
    }
    return 0;
}
