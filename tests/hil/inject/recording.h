// SPDX-License-Identifier: BSD-2-Clause
// A recorded log, decoded into memory: what sensors will have measured.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "platform/base/samples.h"

namespace facet::hil {

struct RecordedFrame {
    Timestamp stamp;  ///< exposure midpoint
    std::vector<std::uint8_t> left;
    std::vector<std::uint8_t> right;  ///< empty if the log has none
};

struct Recording {
    int width = 0;
    int height = 0;
    std::vector<ImuSample> imu;         ///< of all turns
    std::vector<RecordedFrame> frames;  ///< of the first turn; those of the others differ by their stamps only
    int turns = 1;
    Duration turn;  ///< from a turn's first frame to the next turn's
};

/// Mean time between inertial samples.
Duration imu_period(const Recording& recording);

/// What of the log is taken; as --start and --duration of facet replay.
struct RecordingPart {
    double start_s = 0.0;
    double duration_s = 0.0;  ///< 0: to the end
    bool images = true;
    int turns = 1;  ///< how often it is played without a seam, as --loops of facet replay; it must end as it began
};

/// Reads the part of an ASL folder that a replay with the same arguments would read, and decodes it at once, so that no
/// time is spent on it later: 0.7 MB a stereo pair. Throws std::runtime_error if there is nothing to be read.
Recording load_recording(const std::string& folder, const RecordingPart& part);

}  // namespace facet::hil
