// SPDX-License-Identifier: BSD-2-Clause
// Landmarks by id: order, removal, reuse of storage, and what happens when full.
#include "estimator/window/landmark_store.h"

#include <catch2/catch.hpp>
#include <memory>

namespace facet::landmark_store_test {

TEST_CASE("landmarks are found by id and iterate in order of ids", "[landmark_store]") {
    const auto store = std::make_unique<LandmarkStore>();
    for (const std::uint32_t id : {7U, 3U, 11U, 5U}) {
        REQUIRE(store->find_or_insert({id}) != nullptr);
    }
    CHECK(store->size() == 4);
    CHECK(store->find({5}) == store->find_or_insert({5}));
    CHECK(store->find({4}) == nullptr);
    for (int i = 1; i < store->size(); ++i) {
        CHECK((*store)[i - 1].id < (*store)[i].id);
    }
    store->remove_if([](const Landmark& l) { return l.id.value == 3 || l.id.value == 7; });
    CHECK(store->size() == 2);
    CHECK((*store)[0].id == LandmarkId{5});
    CHECK(store->find({7}) == nullptr);
}

TEST_CASE("a full store makes room by the ended tracks with the fewest sightings", "[landmark_store]") {
    // GIVEN a full store: ids 0 to 9 are still tracked, the others ended; of these 20 to 29 were seen once, 30 twice
    constexpr int kNewest = 5;
    const auto store = std::make_unique<LandmarkStore>();
    for (std::uint32_t id = 0; id < static_cast<std::uint32_t>(kMaxLandmarks); ++id) {
        auto& observations = store->find_or_insert({id})->observations;
        const int seen = id < 10 || (id >= 20 && id < 30) ? 1 : (id == 30 ? 2 : 3);
        for (int k = 0; k < seen; ++k) {
            observations.push_back({});
            observations.back().keyframe = id < 10 ? kNewest : k;
        }
    }
    // WHEN there is to be room for one, THEN it is the oldest of the shortest
    CHECK(store->make_room(1, kNewest) == 1);
    CHECK(store->find({20}) == nullptr);
    CHECK(store->find({21}) != nullptr);
    // WHEN for more, THEN the shortest go, and no track that goes on
    CHECK(store->make_room(11, kNewest) == 10);
    CHECK(store->find({29}) == nullptr);
    CHECK(store->find({30}) == nullptr);
    CHECK(store->find({31}) != nullptr);
    CHECK(store->make_room(11, kNewest) == 0);
    CHECK(store->make_room(kMaxLandmarks, kNewest) == kMaxLandmarks - 11 - 10);
    CHECK(store->size() == 10);
    CHECK((*store)[9].id.value == 9);
}

TEST_CASE("a full store rejects and takes again after a removal, with fresh contents", "[landmark_store]") {
    const auto store = std::make_unique<LandmarkStore>();
    for (std::uint32_t id = 0; id < static_cast<std::uint32_t>(kMaxLandmarks); ++id) {
        Landmark* landmark = store->find_or_insert({id});
        REQUIRE(landmark != nullptr);
        landmark->observations.push_back({});
        landmark->has_point = true;
    }
    const LandmarkId next{static_cast<std::uint32_t>(kMaxLandmarks)};
    CHECK(store->find_or_insert(next) == nullptr);
    CHECK(store->size() == kMaxLandmarks);
    store->remove_if([](const Landmark& l) { return l.id.value == 100; });
    Landmark* landmark = store->find_or_insert(next);
    REQUIRE(landmark != nullptr);
    CHECK(landmark->observations.empty());
    CHECK_FALSE(landmark->has_point);
}

}  // namespace facet::landmark_store_test
