// SPDX-License-Identifier: BSD-2-Clause
// Problems that the reader of a recorded log reports and works around.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace facet {

enum class AslWarningKind : std::uint8_t {
    kMalformedRow,  ///< a CSV row with a wrong number of fields or a field that is not a number; the row is skipped
    kNotFinite,     ///< a NaN or infinite number; the row is skipped
    kDuplicate,     ///< the stamp of the previous row; the row is skipped
    kOutOfOrder,    ///< a stamp before that of the previous row; the row is skipped
    kMissingRight,  ///< no right image within the tolerance; the frame has no right view
    kMissingLeft,   ///< a right image without a left one
    kApart,         ///< left and right images exposed at different times; one warning for all of them
    kMissingFile,   ///< an image that cannot be read
    kCorruptImage,  ///< a truncated or damaged PNG
    kWrongSize,     ///< an image whose size differs from its camera's
    kImuGap,        ///< inertial samples missing before this row
    kUncovered,     ///< a frame after the last inertial sample, or before the first
    kCount
};

/// Short name used in summaries, snake_case; never null.
const char* to_string(AslWarningKind kind);

struct AslWarning {
    AslWarningKind kind = AslWarningKind::kMalformedRow;
    std::string file;       ///< path of the CSV file
    std::int64_t line = 0;  ///< from 1
    std::string message;    ///< what is wrong and what was done about it

    /// "file:line: message".
    std::string text() const;
};

/// Called on the reader's thread for each warning; may be empty.
using AslWarningSink = std::function<void(const AslWarning&)>;

}  // namespace facet
