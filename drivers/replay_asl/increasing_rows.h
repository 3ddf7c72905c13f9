// SPDX-License-Identifier: BSD-2-Clause
// Keeps the rows of a table whose stamps increase, and reports the others.
#pragma once

#include <optional>
#include <utility>

#include "drivers/replay_asl/warning.h"
#include "platform/base/timestamp.h"

namespace facet {

/// Filter over rows with `Timestamp stamp` and `std::int64_t line`. It looks one row ahead, so that a single stamp far
/// in the future costs one row and not the rest of the log. Thread-bound.
template <class Row>
class IncreasingRows {
public:
    /// Next row whose stamp is after that of the row returned before.
    /// @param read  bool(Row&): the next row of the file, false at its end
    /// @param warn  void(AslWarningKind, std::int64_t line, const char* message), called for each row skipped
    /// @return false at the end
    template <class Read, class Warn>
    bool next(const Read& read, const Warn& warn, Row& out) {
        if (!started_) {
            started_ = true;
            advance(read);
        }
        while (has_ahead_) {
            Row current = std::move(ahead_);
            advance(read);
            if (last_.has_value() && current.stamp == *last_) {
                warn(AslWarningKind::kDuplicate, current.line, "stamp is that of the row before; row skipped");
                continue;
            }
            if (last_.has_value() && current.stamp < *last_) {
                warn(AslWarningKind::kOutOfOrder, current.line, "stamp goes back in time; row skipped");
                continue;
            }
            const bool after_next = has_ahead_ && ahead_.stamp < current.stamp;
            if (after_next && (!last_.has_value() || ahead_.stamp > *last_)) {
                warn(AslWarningKind::kOutOfOrder, current.line, "stamp is after that of the next row; row skipped");
                continue;
            }
            last_ = current.stamp;
            out = std::move(current);
            return true;
        }
        return false;
    }

private:
    template <class Read>
    void advance(const Read& read) {
        ahead_ = Row();
        has_ahead_ = read(ahead_);
    }

    bool started_ = false;
    std::optional<Timestamp> last_;
    Row ahead_;
    bool has_ahead_ = false;
};

}  // namespace facet
