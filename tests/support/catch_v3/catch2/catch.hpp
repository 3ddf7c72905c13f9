// SPDX-License-Identifier: BSD-2-Clause
// Catch2 3 under the one header and the names of Catch2 2, which the tests are written for.
#pragma once

#include <catch2/catch_all.hpp>
#include <string>

using Catch::Approx;

namespace Catch {

/// Catch2 3 has the name in Catch::Matchers, for ranges.
inline auto Contains(const std::string& part) { return Matchers::ContainsSubstring(part); }

}  // namespace Catch
