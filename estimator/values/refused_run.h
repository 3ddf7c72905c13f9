// SPDX-License-Identifier: BSD-2-Clause
// What data refused for their stamps show about the clock that they were stamped with.
#pragma once

#include "platform/base/timestamp.h"

namespace facet {

/// Data in a row whose stamps have been before: a clock has gone back, and time that passes meanwhile is on no clock.
/// Single stamps gone wrong, however far, cover no time and are no clock: a clock goes on as time does, for half a
/// second. Thread-bound. No heap.
class RefusedRun {
public:
    static constexpr double kLeast_s = 0.1;  ///< two samples or frames out of order are no run
    static constexpr double kClock_s = 0.5;  ///< stamps that go on for this long are a clock's
    static constexpr double kStep_s = 0.25;  ///< longest step from one stamp of a clock to the next

    void add(Timestamp stamp);

    /// Ends the run. @return the time it covers, by steps of a clock (s)
    double take_s();

    /// The newest stamps come from a clock, which began at clock_begin() and stands at newest().
    bool is_clock() const { return !is_empty_ && (newest_ - clock_begin_).seconds() >= kClock_s; }
    Timestamp clock_begin() const { return clock_begin_; }
    Timestamp newest() const { return newest_; }

private:
    Duration covered_;
    Timestamp newest_;       ///< added last
    Timestamp clock_begin_;  ///< from here on stamps have gone on to newest_
    bool is_empty_ = true;
};

}  // namespace facet
