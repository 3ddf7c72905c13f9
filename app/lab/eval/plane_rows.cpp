// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/plane_rows.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "app/support/input_error.h"
#include "drivers/replay_asl/csv_file.h"

namespace facet {
namespace {

constexpr std::array kColumns{"stamp_ns",  "id",      "nx", "ny", "nz", "distance_m",
                              "landmarks", "area_m2", "cx", "cy", "cz"};

PlaneRow row_of(const std::array<double, kColumns.size()>& v, Timestamp stamp) {
    PlaneRow row;
    row.stamp = stamp;
    row.id = static_cast<std::uint32_t>(v[1]);
    row.normal = {v[2], v[3], v[4]};
    row.distance = v[5];
    row.landmarks = v[6];
    row.area_m2 = v[7];
    row.centroid = {v[8], v[9], v[10]};
    return row;
}

}  // namespace

std::vector<PlaneRow> read_planes(const std::string& path) {
    CsvFile csv;
    if (!csv.open(path)) {
        throw InputError(path + ": cannot be read");
    }
    std::vector<std::string_view> fields;
    std::array<std::size_t, kColumns.size()> at{};
    if (csv.next(fields)) {
        for (std::size_t i = 0; i < kColumns.size(); ++i) {
            const auto found = std::find(fields.begin(), fields.end(), kColumns[i]);
            if (found == fields.end()) {
                throw InputError(fmt::format("{}:{}: no column {}", path, csv.line(), kColumns[i]));
            }
            at[i] = static_cast<std::size_t>(found - fields.begin());
        }
    }
    const std::size_t columns = fields.size();
    std::vector<PlaneRow> rows;
    while (csv.next(fields)) {
        std::array<double, kColumns.size()> values{};
        Timestamp stamp;
        bool is_good = fields.size() == columns && parse_int64(fields[at[0]], stamp.ns);
        for (std::size_t i = 1; i < kColumns.size() && is_good; ++i) {
            is_good = parse_double(fields[at[i]], values[i]) && std::isfinite(values[i]);
        }
        if (!is_good) {
            throw InputError(fmt::format("{}:{}: not a row of planes", path, csv.line()));
        }
        rows.push_back(row_of(values, stamp));
    }
    return rows;
}

}  // namespace facet
