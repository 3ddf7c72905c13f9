// SPDX-License-Identifier: BSD-2-Clause
#include "app/output/map_file.h"

#include <array>
#include <catch2/catch.hpp>
#include <cstring>
#include <fstream>
#include <memory>

#include "app/output/place_log.h"
#include "app/support/input_error.h"
#include "tests/mesh/places/textured_room.h"
#include "tests/support/temp_dir.h"

namespace facet::map_file_test {
namespace {

/// A memory that a short flight has filled.
std::unique_ptr<PlaceMemory> filled_memory() {
    const test::TexturedRoom room;
    test::RoomFlight flight(room);
    auto memory = std::make_unique<PlaceMemory>();
    memory->configure(test::scene_rig());
    for (int i = 0; i < 4; ++i) {
        const KeyframeView& view = flight.fly_to(test::looking({-1.0, 1.2 * i - 2.0, 0.1}, 0.0));
        memory->add(view, 0, flight.image());
        memory->finish();
    }
    return memory;
}

void write_bytes(const std::string& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

/// The message with which a map of these bytes is refused; empty if it is read.
std::string refusal(const test::TempDir& dir, const std::string& bytes) {
    write_bytes(dir.file("changed.map"), bytes);
    try {
        (void)read_map(dir.file("changed.map"));
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

/// With a checksum that fits.
std::string sealed(std::string bytes) {
    bytes.resize(bytes.size() - 8);
    std::uint64_t hash = 0xcbf29ce484222325ULL;
    for (const char c : bytes) {
        hash = (hash ^ static_cast<std::uint8_t>(c)) * 0x100000001b3ULL;
    }
    bytes.append(reinterpret_cast<const char*>(&hash), sizeof(hash));
    return bytes;
}

}  // namespace

TEST_CASE("a map is read as it was written") {
    const test::TempDir dir;
    const std::unique_ptr<PlaceMemory> memory = filled_memory();
    REQUIRE(memory->size() > 1);
    write_map(dir.file("room.map"), *memory);
    const std::vector<MappedPlace> places = read_map(dir.file("room.map"));
    REQUIRE(places.size() == memory->size());
    for (std::size_t i = 0; i < places.size(); ++i) {
        const MappedPlace written = memory->place(i);
        CHECK(places[i].view.stamp.ns == written.view.stamp.ns);
        CHECK(places[i].T_M_K.yaw == written.T_M_K.yaw);
        CHECK(places[i].T_M_K.p == written.T_M_K.p);
        CHECK(places[i].view.q_G_C.angularDistance(written.view.q_G_C) < 1e-3F);
        CHECK(places[i].view.depth_m == written.view.depth_m);
        REQUIRE(places[i].view.points.size() == written.view.points.size());
        const PlacePoint& point = places[i].view.points.back();
        const PlacePoint& original = written.view.points.back();
        CHECK(point.p_G == original.p_G);
        CHECK(point.depth_sigma == original.depth_sigma);
        CHECK(point.code.distance_to(original.code) == 0);
        CHECK(point.patch == original.patch);
    }
}

TEST_CASE("a map that is cut short anywhere, changed in any byte, or no map, is refused by name") {
    const test::TempDir dir;
    write_map(dir.file("room.map"), *filled_memory());
    const std::string bytes = test::read_file(dir.file("room.map"));
    for (std::size_t length = 0; length < bytes.size(); length += 1 + length / 8) {
        CHECK(refusal(dir, bytes.substr(0, length)).find("changed.map: ") != std::string::npos);
    }
    for (std::size_t i = 0; i < bytes.size(); i += 1 + i / 8) {
        std::string changed = bytes;
        changed[i] = static_cast<char>(changed[i] ^ 0x10);
        CHECK(!refusal(dir, changed).empty());
    }
    CHECK(refusal(dir, "a text").find("no map of facet") != std::string::npos);
    CHECK(!refusal(dir, sealed(bytes + "more")).empty());
    CHECK_THROWS_AS(read_map(dir.file("not_there.map")), InputError);
}

TEST_CASE("values that no map can have are refused even with a checksum that fits") {
    const test::TempDir dir;
    write_map(dir.file("room.map"), *filled_memory());
    const std::string bytes = test::read_file(dir.file("room.map"));
    REQUIRE(refusal(dir, sealed(bytes)).empty());
    const auto with = [&](std::size_t at, const auto& value) {
        std::string changed = bytes;
        std::memcpy(changed.data() + at, &value, sizeof(value));
        return refusal(dir, sealed(changed));
    };
    CHECK(with(8, std::uint32_t{1}).find("version 1") != std::string::npos);
    CHECK(!with(12, std::uint32_t{0xffffffff}).empty());  // places
    CHECK(!with(12, std::uint32_t{1}).empty());           // fewer than there are
    constexpr std::size_t kPlace = 16;
    CHECK(!with(kPlace + 8, std::numeric_limits<double>::quiet_NaN()).empty());  // yaw
    CHECK(!with(kPlace + 16, std::numeric_limits<double>::infinity()).empty());  // position
    CHECK(!with(kPlace + 40, std::array<float, 4>{}).empty());                   // attitude
    CHECK(!with(kPlace + 56, -1.0F).empty());                                    // depth
    CHECK(!with(kPlace + 60, -1.0F).empty());                                    // its uncertainty
    CHECK(!with(kPlace + 64, std::uint16_t{60000}).empty());                     // points
    CHECK(!with(kPlace + 66, std::numeric_limits<float>::quiet_NaN()).empty());  // a point's place
    CHECK(!with(kPlace + 66 + 16, std::int8_t{100}).empty());                    // its octave
}

TEST_CASE("the log of places has a row for each view compared, and the path in the map") {
    const test::TempDir dir;
    const test::TexturedRoom room;
    test::RoomFlight flight(room);
    PlaceMemory memory;
    memory.configure(test::scene_rig());
    PlaceLog log(dir.path());
    for (int i = 0; i < 16; ++i) {  // there, and back when the window has forgotten the first view
        const Se3 T_W_C = test::looking({-1.0, 0.6 * (i < 8 ? i : 15 - i), 0.0}, 0.0);
        const KeyframeView& view = flight.fly_to(T_W_C);
        memory.add(view, 0, flight.image());
        memory.finish();
        Estimate estimate;
        estimate.stamp = {i * 1'000'000};
        log.write(estimate, i > 0, memory);
    }
    log.close();
    const std::string rows = test::read_file(dir.file("places.csv"));
    CHECK(rows.starts_with("stamp_ns,place_stamp_ns,accepted,"));
    CHECK(std::ranges::count(rows, '\n') >= 1 + memory.counters().stations);
    CHECK(rows.find("500000000,,0,") != std::string::npos);            // nothing known yet
    CHECK(rows.find("8000000000,500000000,1,") != std::string::npos);  // the first view again
    const std::string path = test::read_file(dir.file("trajectory_map.tum"));
    CHECK(std::ranges::count(path, '\n') == 15);
}

}  // namespace facet::map_file_test
