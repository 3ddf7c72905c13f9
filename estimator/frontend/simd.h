// SPDX-License-Identifier: BSD-2-Clause
// Vectors of floats in the compiler's own notation: one source for AVX2, SSE and NEON.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#if defined(__AVX2__)
#include <immintrin.h>
#elif defined(__ARM_NEON)
#include <arm_neon.h>
#endif

#include "estimator/frontend/row_pairs.h"

namespace facet::simd {

#ifdef __AVX2__
inline constexpr int kLanes = 8;
#else
inline constexpr int kLanes = 4;
#endif

/// Bytes that load_bytes() may read past the last pixel they use: image buffers have that much to spare.
inline constexpr std::size_t kOverread = 16;

using Floats = float __attribute__((vector_size(4 * kLanes)));
using Quad = float __attribute__((vector_size(16)));
using Ints = std::int32_t __attribute__((vector_size(4 * kLanes)));

inline Floats load(const float* p) {
    Floats v;
    std::memcpy(&v, p, sizeof(v));
    return v;
}

inline void store(float* p, const Floats& v) { std::memcpy(p, &v, sizeof(v)); }

inline Floats splat(float x) { return Floats{} + x; }

/// a * b + c, rounded once where the processor has an instruction for it. The instruction is named explicitly, because
/// the compiler must not contract by itself and only sometimes vectorizes a loop over std::fma.
inline Floats multiply_add(const Floats& a, const Floats& b, const Floats& c) {
#if defined(__AVX2__) && defined(__FMA__)
    return _mm256_fmadd_ps(a, b, c);
#elif defined(__ARM_NEON)
    return vfmaq_f32(c, a, b);
#else
    return a * b + c;
#endif
}

inline Floats to_floats(const Ints& v) { return __builtin_convertvector(v, Floats); }
/// Towards zero.
inline Ints to_ints(const Floats& v) { return __builtin_convertvector(v, Ints); }

inline Floats clamp(const Floats& v, float least, float most) {
    const Floats low = splat(least);
    const Floats high = splat(most);
    const Floats raised = v < low ? low : v;
    return raised > high ? high : raised;
}

/// Adds halves to halves, a vector at a time: summing lane by lane takes three times the instructions.
inline float sum(const Floats& v) {
#ifdef __AVX2__
    const Quad four = __builtin_shufflevector(v, v, 0, 1, 2, 3) + __builtin_shufflevector(v, v, 4, 5, 6, 7);
#else
    const Quad four = v;
#endif
    const Quad two = four + __builtin_shufflevector(four, four, 2, 3, 2, 3);
    return two[0] + two[1];
}

inline float greatest(const Floats& v) {
    float best = v[0];
    for (int i = 1; i < kLanes; ++i) {
        best = v[i] > best ? v[i] : best;
    }
    return best;
}

/// Whether any lane of a comparison's result holds.
inline bool any(const Ints& mask) {
    std::uint64_t parts[sizeof(Ints) / 8];
    std::memcpy(parts, &mask, sizeof(mask));
    std::uint64_t all = 0;
    for (const std::uint64_t part : parts) {
        all |= part;
    }
    return all != 0;
}

/// Pixels p[0] ... p[kLanes - 1] as floats.
inline Floats load_bytes(const std::uint8_t* p) {
#ifdef __AVX2__
    return _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(p))));
#else
    return Floats{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2]),
                  static_cast<float>(p[3])};
#endif
}

/// Grey values at (u, v), bilinearly interpolated. 0 <= u < width - 1 and 0 <= v < height - 1. One load of four bytes
/// per lane fetches all four neighbours; gather instructions were tried and are slower than single loads. Offsets are
/// exact in float: images have fewer than 2^24 pixels.
inline Floats sample(const RowPairs& image, const Floats& u, const Floats& v) {
    const Floats iu = to_floats(to_ints(u));
    const Floats iv = to_floats(to_ints(v));
    const Floats fu = u - iu;
    const Floats fv = v - iv;
    const Ints at = to_ints(multiply_add(iv, splat(static_cast<float>(image.stride)), iu));
    std::uint64_t index[kLanes / 2];  // two per word: fewer moves from vector to scalar registers
    std::memcpy(index, &at, sizeof(at));
    Ints quad;
    for (int i = 0; i < kLanes; ++i) {
        const std::uint64_t offset = i % 2 == 0 ? index[i / 2] & 0xffffffffU : index[i / 2] >> 32U;
        std::int32_t word = 0;
        std::memcpy(&word, image.data + offset, sizeof(word));
        quad[i] = word;
    }
    // Bytes from the lowest: (u, v), (u, v + 1), (u + 1, v), (u + 1, v + 1).
    const Floats p0 = to_floats(quad & 255);
    const Floats q0 = to_floats((quad >> 8) & 255);
    const Floats p1 = to_floats((quad >> 16) & 255);
    const Floats q1 = to_floats((quad >> 24) & 255);
    const Floats top = multiply_add(fu, p1 - p0, p0);
    const Floats bottom = multiply_add(fu, q1 - q0, q0);
    return multiply_add(fv, bottom - top, top);
}

}  // namespace facet::simd
