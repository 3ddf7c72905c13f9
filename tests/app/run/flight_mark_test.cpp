// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/flight_mark.h"

#include <catch2/catch.hpp>
#include <filesystem>

#include "tests/support/temp_dir.h"

namespace facet {
namespace {

TEST_CASE("a run knows whether the one before it was broken off") {
    const test::TempDir dir;
    const std::string folder = dir.file("runtime");
    std::filesystem::create_directory(folder);
    const FlightMark first(folder);
    CHECK_FALSE(first.is_continued());
    first.set();
    const FlightMark second(folder);  // the first one was killed
    CHECK(second.is_continued());
    CHECK(FlightMark(folder).is_continued());  // the second one, too, before its sensors worked
    second.set();
    second.clear();
    CHECK_FALSE(FlightMark(folder).is_continued());
    CHECK_FALSE(FlightMark(folder).is_continued());  // one whose sensors were not there
}

TEST_CASE("a runtime folder that is missing or not given is no obstacle") {
    const test::TempDir dir;
    for (const std::string& folder : {std::string(), dir.file("none")}) {
        const FlightMark mark(folder);
        mark.set();
        CHECK_FALSE(FlightMark(folder).is_continued());
        mark.clear();
    }
    CHECK_FALSE(std::filesystem::exists(dir.file("none")));
}

}  // namespace
}  // namespace facet
