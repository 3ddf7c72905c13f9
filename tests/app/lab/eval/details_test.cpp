// SPDX-License-Identifier: BSD-2-Clause
// The tables that plots are drawn from hold what the figures are made of.
#include "app/lab/eval/details.h"

#include <array>
#include <catch2/catch.hpp>
#include <charconv>
#include <cmath>
#include <string_view>

#include "app/lab/eval/evaluation.h"
#include "tests/support/temp_dir.h"

namespace facet::details_test {
namespace {

/// Numbers of a CSV file, its header aside.
std::vector<std::vector<double>> rows_of(const std::string& text) {
    std::vector<std::vector<double>> rows;
    std::size_t begin = text.find('\n') + 1;
    while (begin < text.size()) {
        const std::size_t end = text.find('\n', begin);
        rows.emplace_back();
        while (begin < end) {
            const std::size_t comma = std::min(text.find(',', begin), end);
            double value = NAN;
            std::from_chars(text.data() + begin, text.data() + comma, value);
            rows.back().push_back(value);
            begin = comma + 1;
        }
        begin = end + 1;
    }
    return rows;
}

/// Along x at 1 m/s for 10 s, 20 Hz; the estimate is 1 % too long and beside it.
std::vector<PosePair> pairs() {
    std::vector<PosePair> result;
    for (int i = 0; i <= 200; ++i) {
        const double x = 0.05 * i;
        const Eigen::Quaterniond level = Eigen::Quaterniond::Identity();
        result.push_back({Timestamp{1000000000 + 50000000LL * i},
                          {level, {x, std::sin(x), 0}},
                          {level, {1.01 * x, std::sin(x), 5}}});
    }
    return result;
}

TEST_CASE("absolute errors of all poses give the figure of the evaluation") {
    const test::TempDir dir;
    const AbsoluteError figure = absolute_error(pairs(), AlignmentMode::kSe3);
    write_absolute_errors(pairs(), figure.T_true_est, dir.file("ate.csv"));
    const auto rows = rows_of(test::read_file(dir.file("ate.csv")));
    REQUIRE(rows.size() == 201);
    double squares = 0.0;
    for (const std::vector<double>& row : rows) {
        REQUIRE(row.size() == 9);
        const double apart = std::hypot(row[4] - row[1], row[5] - row[2], row[6] - row[3]);
        CHECK(row[7] == Approx(apart).margin(2e-6));
        squares += row[7] * row[7];
    }
    CHECK(std::sqrt(squares / 201.0) == Approx(figure.translation_m.rmse).epsilon(1e-6));
    CHECK(figure.translation_m.rmse > 0.01);
    CHECK(rows.front()[0] == 1e9);
}

TEST_CASE("relative errors of all stretches give the figures of the evaluation") {
    const test::TempDir dir;
    const std::array<double, 2> lengths{1.0, 5.0};
    write_relative_errors(pairs(), lengths, dir.file("rpe.csv"));
    const auto rows = rows_of(test::read_file(dir.file("rpe.csv")));
    std::size_t seen = 0;
    for (const double length : lengths) {
        const RelativeError figure = relative_error(pairs(), length);
        double sum = 0.0;
        std::size_t count = 0;
        for (const std::vector<double>& row : rows) {
            sum += row[0] == length ? row[2] : 0.0;
            count += row[0] == length ? 1 : 0;
        }
        CHECK(count == figure.translation_m.count);
        CHECK(sum / static_cast<double>(count) == Approx(figure.translation_m.mean).epsilon(1e-6));
        seen += count;
    }
    CHECK(seen == rows.size());
}

TEST_CASE("distances of a mesh are those of its corners and sides, in the true world") {
    const test::TempDir dir;
    const TriangleSoup floor{{{-9, -9, 0}, {9, -9, 0}, {0, 9, 0}}, {{0, 1, 2}}};
    const TriangleSoup ramp{{{0, 0, 0}, {1, 0, 0.2}, {0, 1, 9}}, {{0, 1, 2}}};
    const Se3 lifted{Eigen::Quaterniond::Identity(), {0, 0, 0.1}};
    write_mesh_distances(ramp, floor, lifted, 2.0, dir.file("mesh_distance.csv"));
    const auto rows = rows_of(test::read_file(dir.file("mesh_distance.csv")));
    REQUIRE(rows.size() == 1);
    const std::array<double, 6> expected{0.1, 0.3, 2.0, 0.2, 2.0, 2.0};  // 2 m: the limit
    for (std::size_t k = 0; k < expected.size(); ++k) {
        CHECK(rows[0][k] == Approx(expected[k]).margin(1e-4));
    }
}

}  // namespace
}  // namespace facet::details_test
