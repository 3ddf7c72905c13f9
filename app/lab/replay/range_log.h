// SPDX-License-Identifier: BSD-2-Clause
// Readings of a range finder in a log: range0/data.csv.
#pragma once

#include <string>
#include <vector>

#include "drivers/replay_asl/log_files.h"
#include "platform/base/range_sample.h"

namespace facet {

/// A row a reading: stamp (ns), x, y, z: where the beam met the ground, in the body (m); and optionally the stamp of
/// the frame before which the estimator was given it, else it is given before the first frame not before it. A row
/// that cannot be read throws InputError naming file and line. Usage, before each frame:
///   while (const RangeSample* sample = log.next_before(frame.stamp)) { pipeline.add_range(*sample); }
/// Thread-bound. Heap in the constructor only.
class RangeLog {
public:
    RangeLog() = default;
    /// @param dataset  a log's folder; without range0/data.csv in it there are no readings
    /// @param files    where its files are, if not on the disk
    explicit RangeLog(const std::string& dataset, LogFiles* files = nullptr);

    /// The next reading that was given before a frame; nullptr: there is none any more.
    const RangeSample* next_before(Timestamp frame);
    std::size_t size() const { return rows_.size(); }

private:
    struct Row {
        RangeSample sample;
        Timestamp given;
    };
    std::vector<Row> rows_;
    std::size_t next_ = 0;
};

}  // namespace facet
