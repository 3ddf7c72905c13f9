// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/replay_asl/csv_file.h"

#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "drivers/replay_asl/increasing_rows.h"
#include "tests/support/temp_dir.h"

namespace facet::csv_file_test {
namespace {

using Rows = std::vector<std::vector<std::string>>;

Rows read_all(const std::string& path, std::vector<std::int64_t>& lines) {
    CsvFile csv;
    REQUIRE(csv.open(path));
    Rows rows;
    std::vector<std::string_view> fields;
    while (csv.next(fields)) {
        rows.emplace_back(fields.begin(), fields.end());
        lines.push_back(csv.line());
    }
    return rows;
}

TEST_CASE("CsvFile gives trimmed fields and the right line numbers") {
    const test::TempDir dir;
    std::vector<std::int64_t> lines;
    // Byte order mark, header comment, CRLF, blank lines, indented comment, empty fields, no newline at the end.
    const std::string path = dir.write("a.csv", "\xEF\xBB\xBF#t,x\r\n1, 2 ,3\r\n\r\n  # note\n,\n4,5");
    CHECK(read_all(path, lines) == Rows{{"1", "2", "3"}, {"", ""}, {"4", "5"}});
    CHECK(lines == std::vector<std::int64_t>{2, 5, 6});
}

TEST_CASE("CsvFile reads an empty file as no rows, and refuses a missing one") {
    const test::TempDir dir;
    std::vector<std::int64_t> lines;
    CHECK(read_all(dir.write("empty.csv", ""), lines).empty());
    CsvFile csv;
    CHECK_FALSE(csv.open(dir.file("missing.csv")));
    CHECK_FALSE(csv.open(dir.path()));
}

TEST_CASE("CsvFile takes no pipe or device, and of a line without end the beginning") {
    const test::TempDir dir;
    CsvFile csv;
    REQUIRE(mkfifo(dir.file("pipe").c_str(), 0600) == 0);
    CHECK_FALSE(csv.open(dir.file("pipe")));
    CHECK_FALSE(csv.open("/dev/zero"));
    std::vector<std::int64_t> lines;
    const std::string length(CsvFile::kMaxLine, '7');
    const std::string path = dir.write(
        "long.csv", "1,2\n" + length + "8,9\n" + std::string(9000, '\0') + "\n3,4\n" + length.substr(1) + "\n5,6");
    const Rows rows = read_all(path, lines);
    REQUIRE(rows.size() == 6);
    CHECK(rows[1] == std::vector<std::string>{length});
    CHECK(rows[2].size() == 1);
    CHECK(rows[3] == std::vector<std::string>{"3", "4"});
    CHECK(rows[4] == std::vector<std::string>{length.substr(1)});
    CHECK(rows[5] == std::vector<std::string>{"5", "6"});
    CHECK(lines == std::vector<std::int64_t>{1, 2, 3, 4, 5, 6});
}

TEST_CASE("stamps at the ends of their type, whose differences overflow, are none") {
    std::int64_t ns = 5;
    CHECK_FALSE(parse_stamp("9223372036854775807", ns));
    CHECK_FALSE(parse_stamp("-9223372036854775808", ns));
    CHECK_FALSE(parse_stamp("1.5", ns));
    CHECK(ns == 5);
    CHECK(parse_stamp("1403636580838555648", ns));
    CHECK(ns == 1403636580838555648);
}

TEST_CASE("numbers are parsed whole or not at all") {
    std::int64_t i = -1;
    CHECK(parse_int64("1403636579763555584", i));
    CHECK(i == 1403636579763555584);
    CHECK(parse_int64("+7", i));
    CHECK(i == 7);
    for (const char* bad : {"", "1.5", "12x", " 1", "99999999999999999999", "0x10"}) {
        INFO(bad);
        CHECK_FALSE(parse_int64(bad, i));
    }
    CHECK(i == 7);
    double d = -1.0;
    CHECK(parse_double("-1.5e-3", d));
    CHECK(d == -1.5e-3);
    CHECK(parse_double("nan", d));
    CHECK(std::isnan(d));
    d = 2.0;
    for (const char* bad : {"", "1,5", "abc", "1.0m", "--1"}) {
        INFO(bad);
        CHECK_FALSE(parse_double(bad, d));
    }
    CHECK(d == 2.0);
}

struct Row {
    Timestamp stamp;
    std::int64_t line = 0;
};

/// Stamps that pass the filter, and the lines it complains of.
std::pair<std::vector<std::int64_t>, std::vector<std::int64_t>> filter(const std::vector<std::int64_t>& stamps) {
    IncreasingRows<Row> rows;
    std::size_t next = 0;
    std::pair<std::vector<std::int64_t>, std::vector<std::int64_t>> result;
    const auto read = [&](Row& row) {
        if (next == stamps.size()) {
            return false;
        }
        row.stamp.ns = stamps[next++];
        row.line = static_cast<std::int64_t>(next);
        return true;
    };
    const auto warn = [&](AslWarningKind, std::int64_t line, const char*) { result.second.push_back(line); };
    Row row;
    while (rows.next(read, warn, row)) {
        result.first.push_back(row.stamp.ns);
    }
    return result;
}

TEST_CASE("IncreasingRows costs one row for one bad stamp") {
    using Lines = std::vector<std::int64_t>;
    CHECK(filter({1, 2, 3}) == std::make_pair(Lines{1, 2, 3}, Lines{}));
    CHECK(filter({1, 1, 2, 2, 2, 3}) == std::make_pair(Lines{1, 2, 3}, Lines{2, 4, 5}));  // duplicates
    CHECK(filter({1, 3, 2, 4}) == std::make_pair(Lines{1, 2, 4}, Lines{2}));              // swapped
    CHECK(filter({1, 2, 900, 3, 4}) == std::make_pair(Lines{1, 2, 3, 4}, Lines{3}));      // one stamp in the future
    CHECK(filter({900, 1, 2}) == std::make_pair(Lines{1, 2}, Lines{1}));                  // the first one is
    CHECK(filter({5, 6, 1, 7}) == std::make_pair(Lines{5, 6, 7}, Lines{3}));              // one in the past
    CHECK(filter({}) == std::make_pair(Lines{}, Lines{}));
}

}  // namespace
}  // namespace facet::csv_file_test
