// SPDX-License-Identifier: BSD-2-Clause
// Checks the table that describes the fields of a configuration struct, whatever the struct.
#pragma once

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <string_view>

#include "platform/base/parameter_field.h"

namespace facet::test {

/// Names differ, texts are there, the defaults are valid, and both ends of every range belong to it. NaN and the values
/// just outside are refused by validate(), and find_out_of_range() returns the field.
template <class Config, std::size_t N>
void check_fields(const std::array<ParameterField<Config>, N>& fields) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    CHECK(Config{}.validate() == Status::kOk);
    std::set<std::string_view> names;
    for (const ParameterField<Config>& field : fields) {
        INFO(std::string(field.name));
        CHECK(names.insert(field.name).second);
        CHECK_FALSE(field.unit.empty());
        CHECK(field.meaning.size() > 5);
        CHECK(field.min < field.max);
        Config config;
        for (const double end : {field.min, field.max}) {
            field.set(config, end);
            CHECK(field.value(config) == end);
            CHECK(find_out_of_range(fields, config) == nullptr);
        }
        const bool is_real = field.type() == ParameterType::kReal;
        for (const double bad : {is_real ? std::nextafter(field.min, -kInfinity) : field.min - 1.0,
                                 is_real ? std::nextafter(field.max, kInfinity) : field.max + 1.0, std::nan("")}) {
            if (!field.can_hold(bad)) {
                continue;  // such as the integer that is one more than the largest
            }
            CAPTURE(bad);
            field.set(config, bad);
            CHECK(config.validate() == Status::kInvalidArgument);
            REQUIRE(find_out_of_range(fields, config) != nullptr);
            CHECK(find_out_of_range(fields, config)->name == field.name);
        }
    }
}

}  // namespace facet::test
