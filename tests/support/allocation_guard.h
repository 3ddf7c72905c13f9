// SPDX-License-Identifier: BSD-2-Clause
// Counts heap allocations in a scope, for tests of code that must not allocate.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace facet::test {

/// Counts the calling thread's heap allocations from construction on. Usage (link facet_allocation_guard):
///   AllocationGuard guard;
///   (void)estimator.add_frame(frame, estimate);
///   const std::uint64_t allocations = guard.allocations();  // read it before a Catch2 macro, which may allocate
///   CHECK(allocations == 0);
/// Every malloc, calloc, realloc, aligned_alloc, memalign and posix_memalign in the program counts, also those made by
/// operator new, Eigen and shared libraries such as OpenCV; free does not. Guards may be nested: each counts on its
/// own. Under AddressSanitizer or ThreadSanitizer, which bring their own malloc, counts stay 0 and active() is false.
/// Thread-bound.
class AllocationGuard {
public:
    AllocationGuard();

    /// Allocations by this thread since construction.
    std::uint64_t allocations() const;
    /// Bytes asked for by them.
    std::uint64_t bytes() const;

    /// Call stack of the first allocation since construction of the thread's newest guard, a line a frame, as
    /// backtrace_symbols() has it (addr2line tells the rest); empty if there was none. Allocates.
    std::string first_allocation() const;

    /// Whether this build counts.
    static bool active();

private:
    std::uint64_t allocations_before_ = 0;
    std::uint64_t bytes_before_ = 0;
};

}  // namespace facet::test
