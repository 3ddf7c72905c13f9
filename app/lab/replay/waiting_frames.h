// SPDX-License-Identifier: BSD-2-Clause
// Frames that wait for inertial samples.
#pragma once

#include <list>

#include "app/lab/faults/owned_frame.h"

namespace facet {

/// Oldest first. The storage of a frame that has gone serves the next ones. Thread-bound. Heap.
class WaitingFrames {
public:
    bool empty() const { return waiting_.empty(); }
    const OwnedFrame& front() const { return waiting_.front(); }
    void pop() { spare_.splice(spare_.end(), waiting_, waiting_.begin()); }

    void add(const StereoFrame& frame, Timestamp output_stamp);
    /// Whether the oldest must not wait longer: there are too many, or one came so much later that a clock has stopped
    /// or jumped.
    bool is_overdue() const;

private:
    std::list<OwnedFrame> waiting_;
    std::list<OwnedFrame> spare_;
};

}  // namespace facet
