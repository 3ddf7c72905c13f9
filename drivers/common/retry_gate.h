// SPDX-License-Identifier: BSD-2-Clause
// Lets a driver try to reopen its device now and then, not all the time.
#pragma once

#include "platform/base/timestamp.h"

namespace facet {

/// Opens once every `period`, counted from the last attempt. Thread-bound. No heap.
class RetryGate {
public:
    explicit RetryGate(Duration period) : period_(period) {}

    /// Closes for a period from now on.
    void close(Timestamp now) { next_ = now + period_; }
    /// Whether an attempt is due; if so, the gate closes again.
    bool pass(Timestamp now) {
        if (now < next_) {
            return false;
        }
        close(now);
        return true;
    }

private:
    Duration period_;
    Timestamp next_;
};

}  // namespace facet
