// SPDX-License-Identifier: BSD-2-Clause
// Takes glibc's allocation functions' place in the whole program, as glibc's manual allows ("Replacing malloc").
#include "tests/support/allocation_guard.h"

#include <execinfo.h>

#include <array>
#include <cerrno>
#include <cstdlib>

#include "tests/support/sanitizers.h"

#if FACET_SANITIZED || !defined(__GLIBC__)
#define FACET_COUNTS_ALLOCATIONS 0
#else
#define FACET_COUNTS_ALLOCATIONS 1
#endif

namespace {

// Constant initialisation and the executable's own TLS block: reading them allocates nothing.
thread_local constinit std::uint64_t t_allocations = 0;
thread_local constinit std::uint64_t t_bytes = 0;
// Call stack of the first allocation after the newest guard was made.
constexpr int kMaxDepth = 32;
thread_local constinit std::array<void*, kMaxDepth> t_stack{};
thread_local constinit int t_depth = 0;
thread_local constinit bool t_wants_stack = false;

[[maybe_unused]] void count(std::size_t bytes) {
    ++t_allocations;
    t_bytes += bytes;
    if (t_wants_stack) {
        t_wants_stack = false;  // first, because backtrace() may itself allocate
        t_depth = backtrace(t_stack.data(), kMaxDepth);
    }
}

}  // namespace

#if FACET_COUNTS_ALLOCATIONS
// The names are glibc's.
extern "C" {
void* __libc_malloc(std::size_t size);                           // NOLINT
void* __libc_calloc(std::size_t count, std::size_t size);        // NOLINT
void* __libc_realloc(void* old, std::size_t size);               // NOLINT
void* __libc_memalign(std::size_t alignment, std::size_t size);  // NOLINT

void* malloc(std::size_t size) {
    count(size);
    return __libc_malloc(size);
}

void* calloc(std::size_t number, std::size_t size) {
    count(number * size);
    return __libc_calloc(number, size);
}

void* realloc(void* old, std::size_t size) {
    count(size);
    return __libc_realloc(old, size);
}

void* memalign(std::size_t alignment, std::size_t size) {
    count(size);
    return __libc_memalign(alignment, size);
}

void* aligned_alloc(std::size_t alignment, std::size_t size) { return memalign(alignment, size); }

int posix_memalign(void** out, std::size_t alignment, std::size_t size) {
    if (alignment % sizeof(void*) != 0 || (alignment & (alignment - 1)) != 0 || alignment == 0) {
        return EINVAL;
    }
    void* const piece = memalign(alignment, size);
    if (piece == nullptr) {
        return ENOMEM;
    }
    *out = piece;
    return 0;
}
}
#endif

namespace facet::test {

AllocationGuard::AllocationGuard() {
    if (t_depth == 0) {  // the very first call of backtrace() loads a library
        static_cast<void>(backtrace(t_stack.data(), 1));
    }
    allocations_before_ = t_allocations;
    bytes_before_ = t_bytes;
    t_depth = 0;
    t_wants_stack = true;
}

std::uint64_t AllocationGuard::allocations() const { return t_allocations - allocations_before_; }

std::uint64_t AllocationGuard::bytes() const { return t_bytes - bytes_before_; }

std::string AllocationGuard::first_allocation() const {
    t_wants_stack = false;  // what follows allocates
    std::string text;
    char** const lines = backtrace_symbols(t_stack.data(), t_depth);
    for (int i = 0; lines != nullptr && i < t_depth; ++i) {
        text += std::string(lines[i]) + "\n";
    }
    std::free(lines);
    return text;
}

bool AllocationGuard::active() { return FACET_COUNTS_ALLOCATIONS != 0; }

}  // namespace facet::test
