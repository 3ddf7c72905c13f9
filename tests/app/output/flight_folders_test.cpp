// SPDX-License-Identifier: BSD-2-Clause
#include "app/output/flight_folders.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "app/support/folder_lock.h"
#include "tests/support/input_error_text.h"
#include "tests/support/temp_dir.h"

namespace facet::flight_folders_test {
namespace {

constexpr std::uint64_t kMegabyte = 1'000'000;
const std::atomic<bool> kGoOn{false};

bool is_there(const test::TempDir& dir, const std::string& name) { return std::filesystem::exists(dir.file(name)); }

/// A flight whose files take up a megabyte and a little more.
std::string make_flight(const test::TempDir& dir) {
    const std::string path = begin_flight(dir.path());
    const std::string name = std::filesystem::path(path).filename().string();
    dir.write(name + "/trajectory.tum", std::string(kMegabyte / 2, '1'));
    dir.write(name + "/mav0/cam0/data/1.png", std::string(kMegabyte / 2, '2'));
    return path;
}

TEST_CASE("each flight gets a folder of its own, numbered onwards") {
    const test::TempDir dir;
    const std::string parent = dir.file("not/there/yet");
    CHECK(begin_flight(parent) == parent + "/flight_00001");
    CHECK(begin_flight(parent) == parent + "/flight_00002");
    std::filesystem::remove(parent + "/flight_00001");
    CHECK(begin_flight(parent) == parent + "/flight_00003");
    // What only looks like a flight does not count; beyond five digits the numbers go on.
    dir.write("not/there/yet/flight_00500", "a file");
    std::filesystem::create_directories(parent + "/flight_9x");
    std::filesystem::create_directories(parent + "/flight_99999999999999999999999999");
    std::filesystem::create_directories(parent + "/flight_99999");
    CHECK(begin_flight(parent) == parent + "/flight_100000");
}

TEST_CASE("a folder for flights that cannot be made is named") {
    const test::TempDir dir;
    dir.write("file", "");
    CHECK(test::input_error_text([&] { (void)begin_flight(dir.file("file/log")); }).find(dir.file("file/log")) == 0);
}

TEST_CASE("the newest flights within the limit are kept, and other files are left alone") {
    const test::TempDir dir;
    for (int i = 0; i < 5; ++i) {
        (void)make_flight(dir);
    }
    dir.write("reset_counter", "7");
    dir.write("flight_00001_copy/trajectory.tum", std::string(kMegabyte, '3'));
    const std::string current = make_flight(dir);
    CHECK(remove_old_flights(dir.path(), {20 * kMegabyte, current}, kGoOn) == 0);
    CHECK(remove_old_flights(dir.path(), {7 * kMegabyte / 2, current}, kGoOn) == 3);
    CHECK_FALSE(is_there(dir, "flight_00001"));
    CHECK_FALSE(is_there(dir, "flight_00003"));
    CHECK(is_there(dir, "flight_00004/mav0/cam0/data/1.png"));
    CHECK(is_there(dir, "flight_00006/trajectory.tum"));
    CHECK(is_there(dir, "reset_counter"));
    CHECK(is_there(dir, "flight_00001_copy/trajectory.tum"));
}

TEST_CASE("the current flight and the one before it stay, however large they are") {
    const test::TempDir dir;
    (void)make_flight(dir);
    (void)make_flight(dir);
    const std::string current = make_flight(dir);
    CHECK(remove_old_flights(dir.path(), {1, current}, kGoOn) == 1);
    CHECK_FALSE(is_there(dir, "flight_00001"));
    CHECK(is_there(dir, "flight_00002/trajectory.tum"));
    CHECK(is_there(dir, "flight_00003/trajectory.tum"));
}

TEST_CASE("a flight that another program is writing stays") {
    const test::TempDir dir;
    const FolderLock other(make_flight(dir));
    (void)make_flight(dir);
    (void)make_flight(dir);
    const std::string current = make_flight(dir);
    CHECK(remove_old_flights(dir.path(), {1, current}, kGoOn) == 1);
    CHECK(is_there(dir, "flight_00001/trajectory.tum"));
    CHECK_FALSE(is_there(dir, "flight_00002"));
}

TEST_CASE("removing stops when asked to, and goes on the next time") {
    const test::TempDir dir;
    (void)make_flight(dir);
    (void)make_flight(dir);
    const std::string current = make_flight(dir);
    const std::atomic<bool> stopping{true};
    CHECK(remove_old_flights(dir.path(), {1, current}, stopping) == 0);
    CHECK(is_there(dir, "flight_00001"));
    CHECK(remove_old_flights(dir.path(), {1, current}, kGoOn) == 1);
}

}  // namespace
}  // namespace facet::flight_folders_test
