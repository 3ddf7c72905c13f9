// SPDX-License-Identifier: BSD-2-Clause
// Writes a row for every frame: processing times, and the estimator's health.
#pragma once

#include <array>
#include <string>

#include "app/support/text_file.h"
#include "estimator/api/estimate.h"
#include "estimator/values/stage.h"

namespace facet {

inline constexpr std::size_t kStageCount = static_cast<std::size_t>(Stage::kCount);

/// What a piece of work took, by both clocks.
struct SpentTime {
    double wall_ms = 0.0;
    double processor_ms = 0.0;  ///< of the estimator's thread: does not grow when others take the core
};

/// Processing time of one frame, without reading and decoding.
struct FrameTiming {
    SpentTime total;
    SpentTime estimate;  ///< of it, up to the estimate; the rest is work that no estimate waits for
    std::array<SpentTime, kStageCount> stages{};
};

/// timing.csv: stamp_ns, is_keyframe, total_ms, estimate_ms and a column a Stage, then the same in CPU time:
/// total_cpu_ms and so on. Throws InputError if it cannot be written.
class TimingWriter {
public:
    explicit TimingWriter(const std::string& folder);
    void write(Timestamp stamp, bool is_keyframe, const FrameTiming& timing);
    void flush() { file_.flush(); }
    void close() { file_.close(); }

private:
    TextFile file_;
};

/// health.csv: stamp_ns and every field of Health, the reasons as a number and as names joined by '|'. Throws
/// InputError if it cannot be written.
class HealthWriter {
public:
    explicit HealthWriter(const std::string& folder);
    void write(Timestamp stamp, const Health& health);
    void flush() { file_.flush(); }
    void close() { file_.close(); }

private:
    TextFile file_;
};

/// Names of HealthReason bits joined by '|'; empty if none is set. Unknown bits appear as "bitN".
std::string reason_names(std::uint32_t reasons);

}  // namespace facet
