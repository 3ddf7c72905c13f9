// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/reset_count.h"

#include <catch2/catch.hpp>
#include <filesystem>

#include "tests/support/temp_dir.h"

namespace facet::reset_count_test {
namespace {

TEST_CASE("the reset counter goes on where the last run ended, however that ended") {
    const test::TempDir dir;
    const std::string folder = dir.file("state");
    {
        ResetCount first(folder);
        CHECK(first.first() == 0);
        CHECK_FALSE(first.is_restart());
        CHECK(first.keep(first.first()).empty());
    }
    {
        // A run that jumped twice, and was killed.
        ResetCount second(folder);
        CHECK(second.first() == 1);
        CHECK(second.is_restart());
        CHECK(second.keep(1).empty());
        CHECK(second.keep(2).empty());
        CHECK(second.keep(3).empty());
    }
    CHECK(ResetCount(folder).first() == 4);
    CHECK(ResetCount(folder).keep(255).empty());
    CHECK(ResetCount(folder).first() == 0);
    CHECK(ResetCount(folder).is_restart());
}

TEST_CASE("a state folder that is missing, spoilt or cannot be written is no obstacle") {
    CHECK(ResetCount("").first() == 0);
    CHECK(ResetCount("").keep(7).empty());
    const test::TempDir dir;
    dir.write("reset_counter", "rubbish\n");
    ResetCount spoilt(std::filesystem::path(dir.file("reset_counter")).parent_path().string());
    CHECK(spoilt.first() == 0);
    CHECK(spoilt.keep(0).empty());
    CHECK(spoilt.keep(0).empty());
    ResetCount nowhere("/proc/nowhere");
    CHECK(nowhere.first() == 0);
    CHECK(nowhere.keep(0).find("/proc/nowhere") != std::string::npos);
    CHECK(nowhere.keep(1).empty());  // said once
}

}  // namespace
}  // namespace facet::reset_count_test
