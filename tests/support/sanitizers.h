// SPDX-License-Identifier: BSD-2-Clause
// Whether a sanitizer has a hand in the program: GCC says so by macros, Clang by features.
#pragma once

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define FACET_SANITIZED 1
#endif
#endif

#if !defined(FACET_SANITIZED)
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define FACET_SANITIZED 1
#else
#define FACET_SANITIZED 0
#endif
#endif

namespace facet::test {

/// AddressSanitizer or ThreadSanitizer: both bring a malloc of their own, and leave mlockall() out.
inline constexpr bool kSanitized = FACET_SANITIZED != 0;

}  // namespace facet::test
