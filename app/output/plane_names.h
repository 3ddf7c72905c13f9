// SPDX-License-Identifier: BSD-2-Clause
// The one id of planes that have had several.
#pragma once

#include <cstdint>
#include <map>

#include "mesh/planes/plane_finder.h"

namespace facet {

/// What the finder has said of a run's ids (PlaneFinder::merges). Heap. Thread-bound.
class PlaneNames {
public:
    void learn(const PlaneMerge& merge) { stays_[merge.gone.value] = merge.stays; }
    /// The id that a plane has now; an invalid one stays so.
    PlaneId now(PlaneId id) const {
        for (auto at = stays_.find(id.value); at != stays_.end(); at = stays_.find(id.value)) {
            id = at->second;  // ids only become smaller
        }
        return id;
    }

private:
    std::map<std::uint32_t, PlaneId> stays_;  ///< by the id that is gone
};

}  // namespace facet
