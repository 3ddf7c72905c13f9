// SPDX-License-Identifier: BSD-2-Clause
// Range tests for configuration values; false for NaN.
#pragma once

namespace facet {

template <class T>
constexpr bool in_range(T value, T low, T high) {
    return value >= low && value <= high;
}

}  // namespace facet
