// SPDX-License-Identifier: BSD-2-Clause
#include "platform/base/parameter_field.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/check_fields.h"

namespace facet::parameter_field_test {
namespace {

struct LampConfig {
    int lamps = 3;
    std::uint32_t seed = 7;
    double current_a = 0.5;
    bool is_dimmed = false;

    std::string_view broken_rule() const { return is_dimmed && current_a > 1.0 ? "current_a is too large to dim" : ""; }
    Status validate() const;
};

constexpr auto kLampFields = std::to_array<ParameterField<LampConfig>>({
    {FACET_FIELD(LampConfig, lamps), "-", 1, 8, "Number of lamps."},
    {FACET_FIELD(LampConfig, seed), "-", 0, 4294967295.0, "Seed of the flicker."},
    {FACET_FIELD(LampConfig, current_a), "A", 0.1, 2, "Current of a lamp."},
    {FACET_FIELD(LampConfig, is_dimmed), "-", 0, 1, "Dim the lamps."},
});

Status LampConfig::validate() const { return validate_fields(kLampFields, *this); }

static_assert(find_out_of_range(kLampFields, LampConfig{}) == nullptr);
static_assert(kLampFields[0].type() == ParameterType::kInteger);
static_assert(kLampFields[1].type() == ParameterType::kInteger);
static_assert(kLampFields[2].type() == ParameterType::kReal);
static_assert(kLampFields[3].type() == ParameterType::kBool);

TEST_CASE("a table knows the ranges of all types of members") { test::check_fields(kLampFields); }

TEST_CASE("a field reads and writes its member and no other") {
    LampConfig config;
    kLampFields[0].set(config, 5.0);
    kLampFields[1].set(config, 4294967295.0);
    kLampFields[2].set(config, 0.25);
    kLampFields[3].set(config, 1.0);
    CHECK(config.lamps == 5);
    CHECK(config.seed == 4294967295U);
    CHECK(config.current_a == 0.25);
    CHECK(config.is_dimmed);
    CHECK(kLampFields[1].value(config) == 4294967295.0);
    CHECK(kLampFields[3].value(config) == 1.0);
}

TEST_CASE("what a member's type cannot hold is known before it is set") {
    CHECK(kLampFields[0].can_hold(-2147483648.0));
    for (const double bad : {2147483648.0, 0.5, 1e300, std::nan("")}) {
        CAPTURE(bad);
        CHECK_FALSE(kLampFields[0].can_hold(bad));
    }
    CHECK_FALSE(kLampFields[1].can_hold(-1.0));
    CHECK(kLampFields[2].can_hold(1e300));
    CHECK_FALSE(kLampFields[3].can_hold(2.0));
}

TEST_CASE("a condition between fields refuses what each range allows") {
    const LampConfig config{.current_a = 1.5, .is_dimmed = true};
    CHECK(find_out_of_range(kLampFields, config) == nullptr);
    CHECK(broken_rule_of(config) == "current_a is too large to dim");
    CHECK(config.validate() == Status::kInvalidArgument);
}

}  // namespace
}  // namespace facet::parameter_field_test
