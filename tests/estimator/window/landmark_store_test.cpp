// SPDX-License-Identifier: BSD-2-Clause
// Landmarks by id: order, removal, reuse of storage, and what happens when full.
#include "estimator/window/landmark_store.h"

#include <catch2/catch.hpp>
#include <memory>

using namespace facet;

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
