// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/places/place_memory.h"

#include <catch2/catch.hpp>
#include <cstring>
#include <memory>
#include <vector>

#include "tests/mesh/places/textured_room.h"
#include "tests/support/allocation_guard.h"

namespace facet::place_memory_test {
namespace {

using test::looking;
using test::RoomFlight;
using test::TexturedRoom;

/// A flight through a room with a memory of its places.
struct RememberedFlight {
    static constexpr int kFrames = 9;  ///< between two keyframes
    RoomFlight flight;
    std::unique_ptr<PlaceMemory> memory = std::make_unique<PlaceMemory>();
    std::uint32_t resets = 0;

    explicit RememberedFlight(const TexturedRoom& room) : flight(room) { memory->configure(test::scene_rig()); }

    void fly_to(const Se3& T_W_C) {
        T_W_C_ = T_W_C;
        const KeyframeView& view = flight.fly_to(T_W_C);
        memory->add(view, resets, flight.image());
        for (int i = 0; i < kFrames; ++i) {
            memory->advance();
        }
    }
    /// Along y, looking along x, there or back; odometry drifts on the way.
    void sweep(double from, double to, const YawPose::Tangent& drift) {
        constexpr int kSteps = 16;
        for (int i = 0; i <= kSteps; ++i) {
            flight.T_O_W = flight.T_O_W.box_plus(drift / kSteps);
            const Eigen::Vector3d way(0.0, (to - from) / kSteps, 0.0);
            flight.covariance = carried_by(way) * flight.covariance * carried_by(way).transpose();
            flight.covariance.diagonal() += (drift / kSteps).cwiseAbs2().cwiseMax(1e-9);
            fly_to(looking({-1.0, from + (to - from) * i / kSteps, 0.1}, 0.1 * (to - from) / 6.0));
        }
    }
    /// How far the present pose in the map is from the truth (m).
    double error() const { return ((memory->map_from_odom() * (flight.T_O_W * T_W_C_)).p - T_W_C_.p).norm(); }

private:
    Se3 T_W_C_;
};

const YawPose::Tangent kDrift(0.02, 0.06, -0.05, 0.03);

}  // namespace

TEST_CASE("the way back corrects what odometry has drifted on the way there") {
    const TexturedRoom room;
    RememberedFlight there(room);
    there.sweep(-3.0, 3.0, kDrift);
    CHECK(there.error() > 0.05);  // nothing has been met again but what has just left the window
    there.sweep(3.0, -3.0, kDrift);
    CHECK(there.memory->is_located());
    CHECK(there.memory->counters().recognised > 8);
    CHECK(there.memory->counters().refused == 0);
    CHECK(there.error() < 0.02);
    CHECK(std::sqrt(there.memory->covariance().diagonal().tail<3>().sum()) < 0.05);
}

TEST_CASE("a drift beyond what odometry admits is believed only if many stations agree") {
    const TexturedRoom room;
    RememberedFlight there(room);
    there.sweep(-3.0, 3.0, {0.0, 0.0, 0.0, 0.0});
    there.flight.T_O_W = YawPose{0.0, {0.6, 0.0, 0.0}};  // a slip that nobody has noticed
    for (int i = 0; i < 5; ++i) {
        there.fly_to(looking({-1.0, 0.3 * i - 3.0, 0.1}, 0.0));
    }
    CHECK(there.memory->counters().recognised == 0);
    CHECK(there.memory->counters().refused > 2);
    for (int i = 5; i < 12; ++i) {
        there.fly_to(looking({-1.0, 0.3 * i - 3.0, 0.1}, 0.0));
    }
    CHECK(there.memory->counters().recognised > 2);
    CHECK(there.error() < 0.02);
}

TEST_CASE("after a restart of the estimate the pose in the map is unknown until places are known again") {
    const TexturedRoom room;
    RememberedFlight there(room);
    there.sweep(-3.0, 3.0, {0.0, 0.0, 0.0, 0.0});
    ++there.resets;
    there.flight.T_O_W = YawPose{1.3, {5.0, -4.0, 1.0}};
    there.fly_to(looking({-1.0, 0.0, 0.1}, 0.0));
    CHECK(!there.memory->is_located());
    for (int i = 1; i < 6; ++i) {
        there.fly_to(looking({-1.0, 0.3 * i, 0.1}, 0.0));
    }
    CHECK(there.memory->is_located());
    CHECK(there.memory->counters().located == 1);
    CHECK(there.error() < 0.02);
}

TEST_CASE("a flight is located in the map of another, and adds to it") {
    const TexturedRoom room;
    RememberedFlight first(room);
    first.sweep(-3.0, 3.0, {0.0, 0.0, 0.0, 0.0});
    std::vector<MappedPlace> map;
    for (std::size_t i = 0; i < first.memory->size(); ++i) {
        map.push_back(first.memory->place(i));
    }
    RememberedFlight second(room);
    REQUIRE(ok(second.memory->load(map)));
    second.flight.T_O_W = YawPose{-2.0, {1.0, 2.0, 0.0}};
    second.fly_to(looking({-1.0, 1.0, 0.1}, 0.0));
    CHECK(!second.memory->is_located());
    for (int i = 1; i < 6; ++i) {
        second.fly_to(looking({-1.0, 1.0 - 0.3 * i, 0.1}, 0.0));
    }
    REQUIRE(second.memory->is_located());
    CHECK(second.error() < 0.02);
    for (int i = 0; i < 6; ++i) {
        second.fly_to(looking({-1.0, 0.0, 0.1}, 0.5 * i));  // looks where the first flight did not
    }
    CHECK(second.memory->size() > map.size());
    CHECK(second.error() < 0.03);
}

TEST_CASE("a flight in another room is not located in a map, and says so") {
    const TexturedRoom here(1);
    const TexturedRoom elsewhere(2);
    RememberedFlight mapped(here);
    mapped.sweep(-3.0, 3.0, {0.0, 0.0, 0.0, 0.0});
    std::vector<MappedPlace> map;
    for (std::size_t i = 0; i < mapped.memory->size(); ++i) {
        map.push_back(mapped.memory->place(i));
    }
    RememberedFlight other(elsewhere);
    REQUIRE(ok(other.memory->load(map)));
    other.sweep(-3.0, 3.0, {0.0, 0.0, 0.0, 0.0});
    CHECK(!other.memory->is_located());
    CHECK(other.memory->counters().recognised == 0);
}

TEST_CASE("in a map of 300 places a flight is located within three seconds") {
    const TexturedRoom rooms[] = {TexturedRoom(1), TexturedRoom(2), TexturedRoom(3), TexturedRoom(4)};
    const YawPose far{0.0, {100.0, 0.0, 0.0}};  // the nearest places are compared first
    std::vector<MappedPlace> map;
    for (const TexturedRoom& room : rooms) {
        RememberedFlight flight(room);
        flight.sweep(-3.0, 3.0, {0.0, 0.0, 0.0, 0.0});
        for (std::size_t i = 0; i < flight.memory->size(); ++i) {
            map.push_back(flight.memory->place(i));
            map.back().T_M_K = (&room == rooms ? far : YawPose()) * map.back().T_M_K;
        }
    }
    const std::size_t first = map.size() / 2;  // of places elsewhere
    for (std::size_t i = first; map.size() < 300; ++i) {
        map.push_back(map[i]);
        map.back().T_M_K.p.x() += 5.0;
    }
    RememberedFlight flight(rooms[0]);
    REQUIRE(ok(flight.memory->load(map)));
    for (int i = 0; i < 6; ++i) {  // three seconds
        flight.fly_to(looking({-1.0, 1.0 - 0.3 * i, 0.1}, 0.0));
    }
    REQUIRE(flight.memory->is_located());
    CHECK((flight.memory->map_from_odom().p - far.p).norm() < 0.05);
}

TEST_CASE("a hover makes few places") {
    const TexturedRoom room;
    RememberedFlight flight(room);
    for (int i = 0; i < 40; ++i) {
        flight.fly_to(looking({0.01 * (i % 3), 0.0, 0.0}, 0.0));
    }
    CHECK(flight.memory->size() == 1U);
    CHECK(flight.memory->counters().nodes <= 20);
    CHECK(flight.memory->counters().recognised > 5);
}

TEST_CASE("remembering and recognising take no heap, and the same flight gives the same bytes") {
    const TexturedRoom room;
    YawPose result[2];
    for (YawPose& end : result) {
        RememberedFlight flight(room);
        flight.sweep(-3.0, 3.0, kDrift);
        std::uint64_t allocations = 0;
        for (int i = 0; i < 10; ++i) {
            const KeyframeView& view = flight.flight.fly_to(looking({-1.0, 3.0 - 0.3 * i, 0.1}, 0.0));
            const test::AllocationGuard guard;
            flight.memory->add(view, 0, flight.flight.image());
            for (int k = 0; k < 9; ++k) {
                flight.memory->advance();
            }
            allocations += guard.allocations();
        }
        CHECK(allocations == 0);
        CHECK(flight.memory->counters().recognised > 3);
        end = flight.memory->map_from_odom();
    }
    CHECK(std::memcmp(&result[0], &result[1], sizeof(YawPose)) == 0);
}

TEST_CASE("images of another size, and keyframes of the right camera, are passed over") {
    const TexturedRoom room;
    RememberedFlight flight(room);
    KeyframeView view = flight.flight.fly_to(looking({0.0, 0.0, 0.0}, 0.0));
    ImageView small = flight.flight.image();
    small.width -= 1;
    flight.memory->add(view, 0, small);
    flight.memory->add(view, 0, {});
    flight.memory->add(view, 0, {nullptr, test::kSceneWidth, test::kSceneHeight, test::kSceneWidth});
    view.is_exchanged = true;
    flight.memory->add(view, 0, flight.flight.image());
    flight.memory->advance();
    CHECK(flight.memory->counters().nodes == 0);
}

}  // namespace facet::place_memory_test
