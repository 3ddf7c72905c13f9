// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/uncertain_states.h"

#include <fmt/core.h>

#include <cctype>
#include <map>

#include "app/support/input_error.h"
#include "drivers/replay_asl/csv_file.h"
#include "drivers/replay_asl/ground_truth.h"

namespace facet {
namespace {

constexpr std::size_t kCovarianceColumns = 1 + kClaimDim * (kClaimDim + 1) / 2;

std::map<Timestamp, ClaimMatrix> read_covariances(const std::string& path) {
    CsvFile csv;
    if (!csv.open(path)) {
        throw InputError(path + ": cannot be read");
    }
    std::map<Timestamp, ClaimMatrix> covariances;
    std::vector<std::string_view> fields;
    bool is_first = true;
    while (csv.next(fields)) {
        const bool is_header = is_first && fields.front() == "stamp_ns";
        is_first = false;
        if (is_header) {
            continue;
        }
        const auto fail = [&](const std::string& what) {
            throw InputError(fmt::format("{}:{}: {}", path, csv.line(), what));
        };
        if (fields.size() != kCovarianceColumns) {
            fail(fmt::format("row has {} columns, not {}", fields.size(), kCovarianceColumns));
        }
        Timestamp stamp;
        if (!parse_int64(fields[0], stamp.ns)) {
            fail("stamp is not an integer (ns)");
        }
        ClaimMatrix covariance;
        std::size_t column = 1;
        for (int i = 0; i < kClaimDim; ++i) {
            for (int j = i; j < kClaimDim; ++j, ++column) {
                if (!parse_double(fields[column], covariance(i, j))) {
                    fail(fmt::format("column {} is not a number", column + 1));
                }
                covariance(j, i) = covariance(i, j);
            }
        }
        covariances[stamp] = covariance;
    }
    if (csv.failed()) {
        throw InputError(path + ": read error");
    }
    return covariances;
}

}  // namespace

std::vector<UncertainState> read_uncertain_states(const std::string& trajectory_csv,
                                                  const std::string& covariance_csv) {
    const std::map<Timestamp, ClaimMatrix> covariances = read_covariances(covariance_csv);
    std::vector<GroundTruthState> rows;
    std::string error;
    if (!ok(read_ground_truth(trajectory_csv, {}, rows, error))) {  // the same 17 columns
        throw InputError(error);
    }
    std::vector<UncertainState> states;
    for (const GroundTruthState& row : rows) {
        if (const auto found = covariances.find(row.stamp); row.has_motion && found != covariances.end()) {
            states.push_back({row.stamp, {row.q_W_B, row.p_W_B}, row.v_W_B, found->second});
        }
    }
    return states;
}

}  // namespace facet
