// SPDX-License-Identifier: BSD-2-Clause
// Every YAML file that users write: parameters, vehicles, calibrations. The first byte chooses the reader.
#include "app/calibration/calibration.h"
#include "app/config/config_file.h"
#include "app/config/vehicle_file.h"
#include "app/support/input_error.h"
#include "tests/fuzz/fuzz_input.h"

using namespace facet;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    test::FuzzInput input(data, size);
    const auto reader = input.take<std::uint8_t>();
    const test::MemoryFile file(input.take_rest());
    try {
        switch (reader % 5) {
            case 0: {
                ProgramConfig config;
                load_config(file.path(), config);
                break;
            }
            case 1: {
                Vehicle vehicle;
                static_cast<void>(check_vehicle(file.path(), vehicle));
                break;
            }
            case 2: {
                Calibration calibration;
                load_kalibr_cameras(file.path(), calibration);
                break;
            }
            case 3: {
                static_cast<void>(load_calibration(file.path(), file.path(), ""));
                break;
            }
            default: {
                Calibration calibration;
                load_kalibr_imu(file.path(), calibration);
                break;
            }
        }
    } catch (const InputError&) {  // the one way to say no
    }
    return 0;
}
