// SPDX-License-Identifier: BSD-2-Clause
// Describes the fields of a configuration struct once; validating, reading, printing and reporting them all use that.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>

#include "platform/base/range_check.h"
#include "platform/base/status.h"

/// The first two members of a ParameterField: a field's name and the pointer to it.
#define FACET_FIELD(config, field) #field, &config::field

namespace facet {

enum class ParameterType : std::uint8_t { kBool, kInteger, kReal };

/// One field of a configuration struct: the only place where its unit, range and meaning are stated. The struct itself
/// holds the default. Values are passed as double, which represents all types of members exactly. Reentrant. No heap.
///
/// Usage, right behind the struct:
///   inline constexpr auto kWindowFields = std::to_array<ParameterField<WindowConfig>>({
///       {FACET_FIELD(WindowConfig, keyframes), "-", 3, kMaxKeyframes, "Number of keyframes in the window."},
///   });
template <class Config>
struct ParameterField {
    using Member = std::variant<bool Config::*, int Config::*, std::uint32_t Config::*, double Config::*>;

    std::string_view name;
    Member member;
    std::string_view unit;  ///< "-" if there is none
    double min;             ///< least value allowed; 0 for a bool
    double max;             ///< largest value allowed; 1 for a bool
    std::string_view meaning;
    std::span<const std::string_view> choices{};  ///< names of an integer's values 0, 1, ...; empty: they have none

    constexpr double value(const Config& config) const {
        return std::visit([&](auto pointer) { return static_cast<double>(config.*pointer); }, member);
    }

    /// The value must be one that the member can hold.
    constexpr void set(Config& config, double value) const {
        std::visit([&](auto pointer) { config.*pointer = static_cast<ValueOf<decltype(pointer)>>(value); }, member);
    }

    /// Whether the member's type has this value. Says nothing about the range.
    constexpr bool can_hold(double value) const {
        return std::visit([&](auto pointer) { return is_value_of<ValueOf<decltype(pointer)>>(value); }, member);
    }

    constexpr ParameterType type() const {
        return std::visit([](auto pointer) { return type_of<ValueOf<decltype(pointer)>>(); }, member);
    }

private:
    template <class Pointer>
    using ValueOf = std::remove_cvref_t<decltype(std::declval<Config&>().*std::declval<Pointer>())>;

    template <class T>
    static constexpr bool is_value_of(double value) {
        if constexpr (std::is_floating_point_v<T>) {
            return true;
        } else {
            using Limits = std::numeric_limits<T>;
            return in_range(value, static_cast<double>(Limits::lowest()), static_cast<double>(Limits::max())) &&
                   static_cast<double>(static_cast<T>(value)) == value;
        }
    }

    template <class T>
    static constexpr ParameterType type_of() {
        if constexpr (std::is_same_v<T, bool>) {
            return ParameterType::kBool;
        } else {
            return std::is_integral_v<T> ? ParameterType::kInteger : ParameterType::kReal;
        }
    }
};

/// The first field whose value is outside its range or not a number; nullptr if there is none.
template <class Config, std::size_t N>
constexpr const ParameterField<Config>* find_out_of_range(const std::array<ParameterField<Config>, N>& fields,
                                                          const Config& config) {
    for (const ParameterField<Config>& field : fields) {
        if (!in_range(field.value(config), field.min, field.max)) {
            return &field;
        }
    }
    return nullptr;
}

/// What ranges cannot express: the condition between fields of `config` that does not hold, as a sentence. Empty if all
/// hold, and for a struct without a function `std::string_view broken_rule() const`.
template <class Config>
constexpr std::string_view broken_rule_of(const Config& config) {
    if constexpr (requires { config.broken_rule(); }) {
        return config.broken_rule();
    } else {
        return {};
    }
}

/// kInvalidArgument if a field is outside its range or a condition between fields does not hold.
template <class Config, std::size_t N>
constexpr Status validate_fields(const std::array<ParameterField<Config>, N>& fields, const Config& config) {
    const bool is_valid = find_out_of_range(fields, config) == nullptr && broken_rule_of(config).empty();
    return is_valid ? Status::kOk : Status::kInvalidArgument;
}

}  // namespace facet
