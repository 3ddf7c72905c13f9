// SPDX-License-Identifier: BSD-2-Clause
#include "platform/base/result.h"

#include <catch2/catch.hpp>
#include <memory>
#include <set>
#include <string>

#include "platform/base/status.h"

namespace facet::result_test {
namespace {

Result<int> half(int x) {
    if (x % 2 != 0) {
        return Status::kInvalidArgument;
    }
    return x / 2;
}

Status quarter(int x, int& out) {
    const Result<int> once = half(x);
    FACET_TRY(once.status());
    const Result<int> twice = half(once.value());
    FACET_TRY(twice.status());
    out = twice.value();
    return Status::kOk;
}

TEST_CASE("a result holds a value or a reason", "[result]") {
    CHECK(half(4).ok());
    CHECK(half(4).value() == 2);
    CHECK(half(4).status() == Status::kOk);
    CHECK_FALSE(half(3).ok());
    CHECK(half(3).status() == Status::kInvalidArgument);
    CHECK(half(3).value_or(-1) == -1);
    CHECK(half(6).value_or(-1) == 3);
}

TEST_CASE("failures travel up and leave outputs untouched", "[result]") {
    int out = 99;
    CHECK(quarter(6, out) == Status::kInvalidArgument);
    CHECK(out == 99);
    CHECK(quarter(8, out) == Status::kOk);
    CHECK(out == 2);
}

TEST_CASE("values that only move can be taken out", "[result]") {
    Result<std::unique_ptr<int>> result(std::make_unique<int>(5));
    REQUIRE(result.ok());
    const std::unique_ptr<int> taken = std::move(result).value();
    CHECK(*taken == 5);
}

TEST_CASE("every status has a name of its own", "[status]") {
    std::set<std::string> names;
    for (int i = 0; i <= static_cast<int>(Status::kEndOfStream); ++i) {
        names.insert(to_string(static_cast<Status>(i)));
    }
    CHECK(names.size() == static_cast<std::size_t>(Status::kEndOfStream) + 1);
    CHECK(names.count("unknown") == 0);
}

}  // namespace
}  // namespace facet::result_test
