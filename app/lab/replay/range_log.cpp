// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/replay/range_log.h"

#include <fmt/core.h>

#include "app/support/input_error.h"
#include "drivers/replay_asl/asl_dataset.h"
#include "drivers/replay_asl/csv_file.h"

namespace facet {

RangeLog::RangeLog(const std::string& dataset, LogFiles* files) {
    const std::string inner = dataset + "/mav0";
    const std::string root =
        files == nullptr ? AslDataset::find_root(dataset) : (files->has_folder(inner) ? inner : dataset);
    const std::string path = root + "/range0/data.csv";
    CsvFile csv;
    if (!(files != nullptr ? csv.open(path, files->open(path)) : csv.open(path))) {
        return;
    }
    std::vector<std::string_view> fields;
    while (csv.next(fields)) {
        Row row;
        bool is_read = fields.size() == 4 || fields.size() == 5;
        is_read = is_read && parse_stamp(fields[0], row.sample.stamp.ns);
        for (int i = 0; i < 3 && is_read; ++i) {
            is_read = parse_double(fields[static_cast<std::size_t>(i) + 1], row.sample.p_B(i));
        }
        row.given = row.sample.stamp;
        is_read = is_read && (fields.size() == 4 || parse_stamp(fields[4], row.given.ns));
        if (!is_read) {
            throw InputError(fmt::format("{}, line {}: not 'stamp,x,y,z' or 'stamp,x,y,z,given'", path, csv.line()));
        }
        if (!rows_.empty() && row.given < rows_.back().given) {
            throw InputError(fmt::format("{}, line {}: given before the row above it", path, csv.line()));
        }
        rows_.push_back(row);
    }
}

const RangeSample* RangeLog::next_before(Timestamp frame) {
    return next_ < rows_.size() && rows_[next_].given <= frame ? &rows_[next_++].sample : nullptr;
}

}  // namespace facet
