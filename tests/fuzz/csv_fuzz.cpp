// SPDX-License-Identifier: BSD-2-Clause
// Tables of numbers: ground truth in EuRoC's form, and single fields.
#include <cmath>
#include <vector>

#include "drivers/replay_asl/csv_file.h"
#include "drivers/replay_asl/ground_truth.h"
#include "tests/fuzz/fuzz_input.h"

using namespace facet;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const test::MemoryFile file({data, size});
    std::vector<GroundTruthState> states;
    std::string error;
    const Status status = read_ground_truth(
        file.path(), [](const AslWarning&) {}, states, error);
    test::require(ok(status) != states.empty());
    test::require(ok(status) == error.empty());
    for (std::size_t i = 0; i < states.size(); ++i) {
        test::require(i == 0 || states[i - 1].stamp < states[i].stamp);
        test::require(states[i].p_W_B.allFinite());
        test::require(std::abs(states[i].q_W_B.norm() - 1.0) < 1e-6);
    }
    CsvFile csv;
    test::require(csv.open(file.path()));
    std::vector<std::string_view> fields;
    while (csv.next(fields)) {
        for (const std::string_view field : fields) {
            std::int64_t integer = 0;
            double number = 0.0;
            static_cast<void>(parse_int64(field, integer));
            static_cast<void>(parse_stamp(field, integer));
            static_cast<void>(parse_double(field, number));
        }
    }
    return 0;
}
