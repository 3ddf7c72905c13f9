// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/replay/range_log.h"

#include <catch2/catch.hpp>
#include <vector>

#include "tests/support/input_error_text.h"
#include "tests/support/temp_dir.h"

namespace facet::range_log_test {
namespace {

std::vector<std::int64_t> given_before(RangeLog& log, std::int64_t frame) {
    std::vector<std::int64_t> stamps;
    while (const RangeSample* sample = log.next_before({frame})) {
        stamps.push_back(sample->stamp.ns);
    }
    return stamps;
}

TEST_CASE("readings are given before the first frame that is not before them") {
    const test::TempDir dir;
    dir.write("mav0/range0/data.csv", "#timestamp [ns],x [m],y [m],z [m]\n100,0.5,0,-1.5\n200,0,0,-1.25\n300,0,0,-1\n");
    RangeLog log(dir.file(""));
    REQUIRE(log.size() == 3);
    CHECK(given_before(log, 99).empty());
    const RangeSample* first = log.next_before({200});
    REQUIRE(first != nullptr);
    CHECK(first->p_B == Eigen::Vector3d(0.5, 0.0, -1.5));
    CHECK(given_before(log, 200) == std::vector<std::int64_t>{200});
    CHECK(given_before(log, 1000) == std::vector<std::int64_t>{300});
}

TEST_CASE("readings that a run was given late are given late again") {
    const test::TempDir dir;
    dir.write("mav0/range0/data.csv", "100,0,0,-1,400\n200,0,0,-1,400\n300,0,0,-1,500\n");
    RangeLog log(dir.file(""));
    CHECK(given_before(log, 399).empty());
    CHECK(given_before(log, 450) == std::vector<std::int64_t>{100, 200});
    CHECK(given_before(log, 500) == std::vector<std::int64_t>{300});
}

TEST_CASE("a log without a range finder has no readings, and a damaged table is named by its line") {
    const test::TempDir dir;
    dir.write("mav0/imu0/data.csv", "");
    CHECK(RangeLog(dir.file("")).size() == 0);
    const auto text_of = [&](const char* rows) {
        dir.write("mav0/range0/data.csv", rows);
        return test::input_error_text([&] { (void)RangeLog(dir.file("")); });
    };
    CHECK_THAT(text_of("100,0,0,-1\n200,0,0\n"), Catch::Contains("line 2: not 'stamp,x,y,z'"));
    CHECK_THAT(text_of("100,0,0,low\n"), Catch::Contains("line 1"));
    CHECK_THAT(text_of("100,0,0,-1,300\n200,0,0,-1,200\n"), Catch::Contains("line 2: given before the row above"));
}

}  // namespace
}  // namespace facet::range_log_test
