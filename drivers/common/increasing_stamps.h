// SPDX-License-Identifier: BSD-2-Clause
// Keeps the stamps of delivered samples increasing.
#pragma once

#include <cstdint>
#include <optional>

#include "platform/base/timestamp.h"

namespace facet {

/// A sample may be delivered if its stamp is after that of the sample delivered last, however long ago that was: clocks
/// are set back, and devices are reopened. Thread-bound. No heap.
class IncreasingStamps {
public:
    /// Whether a sample may be delivered; if not, it is counted. @param refused  is raised by one then
    bool allows(Timestamp stamp, std::uint64_t& refused) const {
        const bool increases = !last_ || stamp > *last_;
        refused += increases ? 0 : 1;
        return increases;
    }
    /// A sample that allows() accepted was delivered.
    void delivered(Timestamp stamp) { last_ = stamp; }
    /// Both, for samples that are delivered as soon as they are allowed.
    bool pass(Timestamp stamp, std::uint64_t& refused) {
        if (!allows(stamp, refused)) {
            return false;
        }
        delivered(stamp);
        return true;
    }

private:
    std::optional<Timestamp> last_;
};

}  // namespace facet
