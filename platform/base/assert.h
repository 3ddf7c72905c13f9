// SPDX-License-Identifier: BSD-2-Clause
// Contract checks for bugs of our own; never used on sensor data, which is judged by Status and Health.
#pragma once

#include <cstdio>
#include <cstdlib>

namespace facet {

[[noreturn]] inline void assert_failed(const char* condition, const char* file, int line) {
    std::fprintf(stderr, "%s:%d: contract violated: %s\n", file, line, condition);
    std::abort();
}

}  // namespace facet

/// Aborts with file and line when a contract of our own code is broken. Kept in release builds.
#define FACET_ASSERT(condition) \
    ((condition) ? static_cast<void>(0) : ::facet::assert_failed(#condition, __FILE__, __LINE__))
