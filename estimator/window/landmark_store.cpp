// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/landmark_store.h"

#include <algorithm>

namespace facet {

LandmarkStore::LandmarkStore() { clear(); }

void LandmarkStore::clear() {
    order_.clear();
    free_.clear();
    for (int slot = kMaxLandmarks - 1; slot >= 0; --slot) {
        free_.push_back(static_cast<std::uint16_t>(slot));
    }
}

Landmark* LandmarkStore::find(LandmarkId id) {
    const auto it =
        std::lower_bound(order_.begin(), order_.end(), id, [](const Entry& e, LandmarkId i) { return e.id < i; });
    return it != order_.end() && it->id == id ? &slots_[it->slot] : nullptr;
}

Landmark* LandmarkStore::find_or_insert(LandmarkId id) {
    const auto it =
        std::lower_bound(order_.begin(), order_.end(), id, [](const Entry& e, LandmarkId i) { return e.id < i; });
    if (it != order_.end() && it->id == id) {
        return &slots_[it->slot];
    }
    if (free_.empty()) {
        return nullptr;
    }
    const std::uint16_t slot = free_.back();
    free_.pop_back();
    order_.insert(it, Entry{id, slot});
    Landmark& landmark = slots_[slot];
    landmark.id = id;
    landmark.observations.clear();
    landmark.has_point = false;
    landmark.is_active = false;
    landmark.cost = 0.0;
    landmark.squared_error = 0.0;
    landmark.plane = landmark.proposed_plane = Landmark::kNoPlane;
    landmark.plane_chi2 = 0.0;
    landmark.plane_misfits = 0;
    return &landmark;
}

}  // namespace facet
