// SPDX-License-Identifier: BSD-2-Clause
// Where the instants come from at which the cameras were triggered to expose, or at which they said they did.
#pragma once

#include <cstdint>

#include "platform/port/source.h"

namespace facet {

/// One edge of a trigger or strobe line.
struct TriggerEdge {
    Timestamp stamp;
    std::uint32_t sequence = 0;  ///< count of edges of this line; gaps are lost edges
    bool rising = true;
    bool numbered = true;  ///< false: only edges that arrived are counted, so that a lost one leaves no gap
};

class TriggerSource : public Source {
public:
    /// Next edge; see Source.
    virtual Status next(Duration timeout, TriggerEdge& edge) = 0;
};

}  // namespace facet
