// SPDX-License-Identifier: BSD-2-Clause
// CAN databases, and frames read with what they say. The first 64 bytes are the frame, the rest the database.
#include <string>

#include "drivers/imu_can/dbc_decoder.h"
#include "tests/fuzz/fuzz_input.h"

using namespace facet;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    test::FuzzInput input(data, size);
    CanFrame frame;
    const auto bytes = input.take_bytes(frame.bytes.size());
    std::copy(bytes.begin(), bytes.end(), frame.bytes.begin());
    DbcFile database;
    std::string error;
    if (!ok(database.parse(input.rest_as_text(), "fuzz.dbc", error))) {
        test::require(!error.empty());
        return 0;
    }
    for (const DbcMessage& message : database.messages()) {
        CanSignalMap map;
        for (std::size_t axis = 0; axis < 3 && axis < message.signals.size(); ++axis) {
            map.rate[axis] = map.force[axis] = {message.name, message.signals[axis].name};
        }
        DbcDecoder decoder;
        if (!ok(decoder.configure(database, map, error))) {
            test::require(!error.empty());
            continue;
        }
        for (const std::uint8_t length : {std::uint8_t{0}, std::uint8_t{3}, std::uint8_t{8}, std::uint8_t{64}}) {
            frame.id = message.id;
            frame.extended = message.extended;
            frame.length = length;
            CanMeasurement measurement;
            static_cast<void>(decoder.decode(frame, measurement));
        }
    }
    return 0;
}
