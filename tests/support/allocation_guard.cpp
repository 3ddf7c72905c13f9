// SPDX-License-Identifier: BSD-2-Clause
// Takes glibc's allocation functions' place in the whole program, as glibc's manual allows ("Replacing malloc").
#include "tests/support/allocation_guard.h"

#include <cerrno>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || !defined(__GLIBC__)
#define FACET_COUNTS_ALLOCATIONS 0
#else
#define FACET_COUNTS_ALLOCATIONS 1
#endif

namespace {

// Constant initialisation and the executable's own TLS block: reading them allocates nothing.
thread_local constinit std::uint64_t t_allocations = 0;
thread_local constinit std::uint64_t t_bytes = 0;

}  // namespace

#if FACET_COUNTS_ALLOCATIONS
// The names are glibc's.
extern "C" {
void* __libc_malloc(std::size_t size);                           // NOLINT
void* __libc_calloc(std::size_t count, std::size_t size);        // NOLINT
void* __libc_realloc(void* old, std::size_t size);               // NOLINT
void* __libc_memalign(std::size_t alignment, std::size_t size);  // NOLINT

void* malloc(std::size_t size) {
    ++t_allocations;
    t_bytes += size;
    return __libc_malloc(size);
}

void* calloc(std::size_t count, std::size_t size) {
    ++t_allocations;
    t_bytes += count * size;
    return __libc_calloc(count, size);
}

void* realloc(void* old, std::size_t size) {
    ++t_allocations;
    t_bytes += size;
    return __libc_realloc(old, size);
}

void* memalign(std::size_t alignment, std::size_t size) {
    ++t_allocations;
    t_bytes += size;
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

AllocationGuard::AllocationGuard() : allocations_before_(t_allocations), bytes_before_(t_bytes) {}

std::uint64_t AllocationGuard::allocations() const { return t_allocations - allocations_before_; }

std::uint64_t AllocationGuard::bytes() const { return t_bytes - bytes_before_; }

bool AllocationGuard::active() { return FACET_COUNTS_ALLOCATIONS != 0; }

}  // namespace facet::test
