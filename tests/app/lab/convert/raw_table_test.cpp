// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/convert/raw_table.h"

#include <catch2/catch.hpp>

#include "tests/support/temp_dir.h"

namespace facet::raw_table_test {
namespace {

/// Header, then stamp and fields of each row, joined by |, then whether the table is regular.
std::string reading_of(const std::string& text) {
    const test::TempDir dir;
    RawTable table;
    REQUIRE(table.open(dir.write("data.csv", text)));
    std::string seen = table.header();
    while (table.next(3, 3)) {
        seen += std::to_string(table.stamp_ns()) + "|" + std::string(table.fields()[0]) + "|" +
                std::string(table.fields()[1]) + "\n";
    }
    return seen + (table.is_regular() ? "regular" : "irregular");
}

}  // namespace

TEST_CASE("regular tables are known as such") {
    CHECK(reading_of("") == "regular");
    CHECK(reading_of("#head\n") == "#head\nregular");
    CHECK(reading_of("#head\n1,a,b\n2,c,\n") == "#head\n1|a|b\n2|c|\nregular");
    CHECK(reading_of("5,a,b\r\n4,c,d\r\n") == "5|a|b\n4|c|d\nregular");
    CHECK(reading_of("#x\r\n# y\r\n1,a,b\r\n") == "#x\r\n# y\r\n1|a|b\nregular");
}

TEST_CASE("whatever rows alone do not tell makes a table irregular") {
    CHECK(reading_of("#head") == "#headirregular");
    CHECK(reading_of("1,a,b\n2,c,d") == "1|a|b\n2|c|d\nirregular");
    CHECK(reading_of("1,a,b\n#note\n2,c,d\n") == "1|a|b\n2|c|d\nirregular");
    CHECK(reading_of("1,a,b\n\n") == "1|a|b\nirregular");
    CHECK(reading_of("1, a,b\n") == "1|a|b\nirregular");
    CHECK(reading_of("+1,a,b\n") == "1|a|b\nirregular");
    CHECK(reading_of("01,a,b\n") == "1|a|b\nirregular");
    CHECK(reading_of("1,a,b\n2,c,d\r\n") == "1|a|b\n2|c|d\nirregular");
    CHECK(reading_of("-1,a,b\n2,c,d\n") == "2|c|d\nirregular");
    CHECK(reading_of("1,a\n2,c,d\n") == "2|c|d\nirregular");
    CHECK(reading_of("x,a,b\n2,c,d\n") == "2|c|d\nirregular");
    CHECK(reading_of("1,a," + std::string(5000, 'x') + "\n2,c,d\n").ends_with("2|c|d\nirregular"));
    CHECK(reading_of("#" + std::string(5000, 'x') + "\n2,c,d\n").ends_with("2|c|d\nirregular"));
}

TEST_CASE("what is no file is no table") {
    const test::TempDir dir;
    RawTable table;
    CHECK_FALSE(table.open(dir.file("missing")));
    CHECK_FALSE(table.open(dir.path()));
    CHECK_FALSE(table.open("/dev/zero"));
}

}  // namespace facet::raw_table_test
