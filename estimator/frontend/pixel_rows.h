// SPDX-License-Identifier: BSD-2-Clause
// What an image pyramid does with whole rows of pixels.
#pragma once

#include <array>
#include <cstdint>

#ifdef __AVX2__
#include <immintrin.h>
#endif

namespace facet::pixel_rows {

#ifdef __AVX2__
/// Calls each(first) for `step` elements at a time; the last ones may overlap those before. @return false: too few
template <class Each>
bool in_steps(int count, int step, Each each) {
    if (count < step) {
        return false;
    }
    int first = 0;
    for (; first + step <= count; first += step) {
        each(first);
    }
    if (first < count) {
        each(count - step);
    }
    return true;
}

template <class T>
__m256i load(const T* p) {
    return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p));
}

template <class T>
void store(T* p, const __m256i& v) {
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), v);
}
#endif

/// Each pixel with the one below it in its high byte: out[u] = upper[u] + 256 lower[u].
inline void pair(const std::uint8_t* upper, const std::uint8_t* lower, int width, std::uint16_t* out) {
#ifdef __AVX2__
    const auto each = [=](int u) {
        const __m256i a = load(upper + u);
        const __m256i b = load(lower + u);
        const __m256i low = _mm256_unpacklo_epi8(a, b);
        const __m256i high = _mm256_unpackhi_epi8(a, b);
        store(out + u, _mm256_permute2x128_si256(low, high, 0x20));
        store(out + u + 16, _mm256_permute2x128_si256(low, high, 0x31));
    };
    if (in_steps(width, 32, each)) {
        return;
    }
#endif
    for (int u = 0; u < width; ++u) {
        out[u] = static_cast<std::uint16_t>(upper[u] | lower[u] << 8);
    }
}

/// Five rows with the weights 1 4 6 4 1: sums of at most 16 * 255.
inline void blur_down(const std::array<const std::uint8_t*, 5>& rows, int width, std::uint16_t* __restrict sums) {
    const std::uint8_t* const r0 = rows[0];
    const std::uint8_t* const r1 = rows[1];
    const std::uint8_t* const r2 = rows[2];
    const std::uint8_t* const r3 = rows[3];
    const std::uint8_t* const r4 = rows[4];
#ifdef __AVX2__
    const auto each = [=](int u) {
        const auto wide = [u](const std::uint8_t* row) {
            return _mm256_cvtepu8_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(row + u)));
        };
        const __m256i middle = wide(r2);
        const __m256i inner = _mm256_add_epi16(_mm256_add_epi16(wide(r1), wide(r3)), middle);
        const __m256i outer = _mm256_add_epi16(wide(r0), wide(r4));
        store(sums + u,
              _mm256_add_epi16(_mm256_add_epi16(outer, _mm256_slli_epi16(inner, 2)), _mm256_add_epi16(middle, middle)));
    };
    if (in_steps(width, 16, each)) {
        return;
    }
#endif
    for (int u = 0; u < width; ++u) {
        sums[u] = static_cast<std::uint16_t>(r0[u] + r4[u] + 4 * (r1[u] + r3[u]) + 6 * r2[u]);
    }
}

/// Every second sum with its neighbours, weights 1 4 6 4 1, as a rounded mean: reads sums[-2] to sums[2 width + 1].
inline void blur_across(const std::uint16_t* sums, int width, std::uint8_t* __restrict out) {
#ifdef __AVX2__
    const auto each = [=](int u) {
        const auto eight = [=](int k) {
            const std::uint16_t* const s = sums + 2 * (u + 8 * k);
            // Pairs of 16 bits, the first of a pair in the low half.
            const __m256i total = _mm256_add_epi32(
                _mm256_add_epi32(_mm256_madd_epi16(load(s - 2), _mm256_set1_epi32(4 << 16 | 1)),
                                 _mm256_madd_epi16(load(s), _mm256_set1_epi32(4 << 16 | 6))),
                _mm256_add_epi32(_mm256_madd_epi16(load(s + 2), _mm256_set1_epi32(1)), _mm256_set1_epi32(128)));
            return _mm256_srli_epi32(total, 8);
        };
        // Packing works in either half by itself: fours of bytes come out in the order 0 2 4 6, 1 3 5 7.
        const __m256i packed =
            _mm256_packus_epi16(_mm256_packus_epi32(eight(0), eight(1)), _mm256_packus_epi32(eight(2), eight(3)));
        store(out + u, _mm256_permutevar8x32_epi32(packed, _mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7)));
    };
    if (in_steps(width, 32, each)) {
        return;
    }
#endif
    for (int u = 0; u < width; ++u) {
        const std::uint16_t* const s = sums + 2 * u;
        out[u] = static_cast<std::uint8_t>((s[-2] + s[2] + 4 * (s[-1] + s[1]) + 6 * s[0] + 128) >> 8);
    }
}

}  // namespace facet::pixel_rows
