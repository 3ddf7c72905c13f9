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

int LandmarkStore::make_room(int wanted, int newest) {
    const auto missing = static_cast<std::size_t>(std::max(0, wanted - static_cast<int>(free_.size())));
    if (missing == 0) {
        return 0;
    }
    boost::container::static_vector<Entry, kMaxLandmarks> ended;
    for (const Entry entry : order_) {
        const auto& observations = slots_[entry.slot].observations;
        if (observations.empty() || observations.back().keyframe < newest) {
            ended.push_back(entry);
        }
    }
    const std::size_t going = std::min(missing, ended.size());
    const auto last = ended.begin() + static_cast<std::ptrdiff_t>(going);
    std::partial_sort(ended.begin(), last, ended.end(), [this](const Entry& a, const Entry& b) {
        const std::size_t seen_a = slots_[a.slot].observations.size();
        const std::size_t seen_b = slots_[b.slot].observations.size();
        return seen_a != seen_b ? seen_a < seen_b : a.id < b.id;
    });
    ended.resize(going);
    std::sort(ended.begin(), ended.end(), [](const Entry& a, const Entry& b) { return a.id < b.id; });
    auto next = ended.begin();
    remove_if([&](const Landmark& landmark) {
        const bool goes = next != ended.end() && next->id == landmark.id;
        next += goes ? 1 : 0;
        return goes;
    });
    return static_cast<int>(going);
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
    landmark.is_projected = false;
    return &landmark;
}

}  // namespace facet
