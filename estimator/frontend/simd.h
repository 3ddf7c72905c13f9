// SPDX-License-Identifier: BSD-2-Clause
// Vectors of floats in the compiler's own notation: one source for AVX2, SSE and NEON.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#if defined(__AVX2__)
#include <immintrin.h>
#elif defined(__ARM_NEON) && defined(__ARM_FEATURE_FMA)
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
#elif defined(__ARM_NEON) && defined(__ARM_FEATURE_FMA)
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

/// A bit for each lane of a comparison's result that holds, that of lane 0 lowest.
inline unsigned lanes_of(const Ints& mask) {
#ifdef __AVX2__
    return static_cast<unsigned>(_mm256_movemask_ps(reinterpret_cast<__m256>(mask)));
#else
    unsigned lanes = 0;
    for (int i = 0; i < kLanes; ++i) {
        lanes |= mask[i] != 0 ? 1U << static_cast<unsigned>(i) : 0U;
    }
    return lanes;
#endif
}

/// Whether any lane of a comparison's result holds.
inline bool any(const Ints& mask) {
#ifdef __AVX2__
    return _mm256_movemask_ps(reinterpret_cast<__m256>(mask)) != 0;
#else
    std::uint64_t parts[sizeof(Ints) / 8];
    std::memcpy(parts, &mask, sizeof(mask));
    std::uint64_t all = 0;
    for (const std::uint64_t part : parts) {
        all |= part;
    }
    return all != 0;
#endif
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

/// The four neighbours of a place in each lane, by the index of the first; bytes from the lowest: (u, v), (u, v + 1),
/// (u + 1, v), (u + 1, v + 1). One load a lane: gather instructions were tried, and are slower on many processors.
inline Ints load_quads(const RowPairs& image, const Ints& offsets) {
    std::uint64_t index[kLanes / 2];  // two per word: fewer moves from vector to scalar registers
    std::memcpy(index, &offsets, sizeof(offsets));
    Ints quads;
    for (int i = 0; i < kLanes; ++i) {
        const std::uint64_t offset = i % 2 == 0 ? index[i / 2] & 0xffffffffU : index[i / 2] >> 32U;
        std::int32_t word = 0;
        std::memcpy(&word, image.data + offset, sizeof(word));
        quads[i] = word;
    }
    return quads;
}

/// The same, in half the instructions if each four lanes lie within seven pixels of one row, their outermost at the
/// ends, as along a curve that runs across the image.
inline Ints load_quads_along(const RowPairs& image, const Ints& offsets) {
#ifdef __AVX2__
    const auto at = reinterpret_cast<__m256i>(offsets);
    const __m256i first = _mm256_min_epi32(_mm256_shuffle_epi32(at, 0x00), _mm256_shuffle_epi32(at, 0xff));
    const __m256i farther = _mm256_sub_epi32(at, first);
    const __m256i most = _mm256_set1_epi32(6);
    const __m256i is_near = _mm256_cmpeq_epi32(_mm256_max_epu32(farther, most), most);
    if (_mm256_movemask_epi8(is_near) == -1) {
        const auto eight = [&](const __m128i& begin) {
            return _mm_loadu_si128(
                reinterpret_cast<const __m128i*>(image.data + static_cast<std::uint32_t>(_mm_cvtsi128_si32(begin))));
        };
        const __m256i pixels = _mm256_inserti128_si256(_mm256_castsi128_si256(eight(_mm256_castsi256_si128(first))),
                                                       eight(_mm256_extracti128_si256(first, 1)), 1);
        const __m256i lowest_bytes = _mm256_set_epi8(12, 12, 12, 12, 8, 8, 8, 8, 4, 4, 4, 4, 0, 0, 0, 0,  //
                                                     12, 12, 12, 12, 8, 8, 8, 8, 4, 4, 4, 4, 0, 0, 0, 0);
        const __m256i each = _mm256_shuffle_epi8(farther, lowest_bytes);
        const __m256i bytes = _mm256_add_epi8(_mm256_add_epi8(each, each), _mm256_set1_epi32(0x03020100));
        return reinterpret_cast<Ints>(_mm256_shuffle_epi8(pixels, bytes));
    }
#endif
    return load_quads(image, offsets);
}

/// Grey values at (u, v), bilinearly interpolated. 0 <= u < width - 1 and 0 <= v < height - 1. Offsets are exact in
/// float: images have fewer than 2^24 pixels.
/// @tparam kAlong  for load_quads_along(); the same values
template <bool kAlong = false>
inline Floats sample(const RowPairs& image, const Floats& u, const Floats& v) {
    const Floats iu = to_floats(to_ints(u));
    const Floats iv = to_floats(to_ints(v));
    const Floats fu = u - iu;
    const Floats fv = v - iv;
    const Ints offsets = to_ints(multiply_add(iv, splat(static_cast<float>(image.stride)), iu));
    const Ints quad = kAlong ? load_quads_along(image, offsets) : load_quads(image, offsets);
    const Floats p0 = to_floats(quad & 255);
    const Floats q0 = to_floats((quad >> 8) & 255);
    const Floats p1 = to_floats((quad >> 16) & 255);
    const Floats q1 = to_floats((quad >> 24) & 255);
    const Floats top = multiply_add(fu, p1 - p0, p0);
    const Floats bottom = multiply_add(fu, q1 - q0, q0);
    return multiply_add(fv, bottom - top, top);
}

/// sample_scaled() takes positions in these units of a pixel: 12 bits behind the point.
inline constexpr float kPositionScale = 4096.0F;
/// The widest and highest image of which it can tell all positions.
inline constexpr int kMaxSide = 4096;
/// What it subtracts from grey values, and then multiplies them by.
inline constexpr float kGreyOrigin = 128.0F;
inline constexpr float kGreyScale = 255.0F * kPositionScale;

/// kGreyScale * (grey value - kGreyOrigin) at (u, v) / kPositionScale, as sample(), but in integers: v counts to 1/255
/// px. The same number with all instruction sets. Images are at most kMaxSide wide and high.
inline Floats sample_scaled(const RowPairs& image, const Floats& u, const Floats& v) {
    const Ints fixed_u = to_ints(u);
    const Ints fixed_v = to_ints(v);
#ifdef __AVX2__
    // Two pixels to a multiplication. That of bytes wants one factor signed: pixels, so that shares may reach 255.
    const auto wide = [](const Ints& x) { return reinterpret_cast<__m256i>(x); };
    const __m256i whole = _mm256_blend_epi16(wide(fixed_u >> 12), wide(fixed_v << 4), 0xaa);
    const __m256i at = _mm256_madd_epi16(whole, _mm256_set1_epi32(1 | static_cast<int>(image.stride) << 16));
    const __m256i quad = wide(load_quads(image, reinterpret_cast<Ints>(at)));
    // (255 - f, f) for each pair of bytes, f from the highest eight bits behind v's point.
    const __m256i lowest_bytes = _mm256_set_epi8(12, 12, 12, 12, 8, 8, 8, 8, 4, 4, 4, 4, 0, 0, 0, 0,  //
                                                 12, 12, 12, 12, 8, 8, 8, 8, 4, 4, 4, 4, 0, 0, 0, 0);
    const __m256i down =
        _mm256_xor_si256(_mm256_shuffle_epi8(wide(fixed_v >> 4), lowest_bytes), _mm256_set1_epi32(0x00ff00ff));
    const __m256i columns = _mm256_maddubs_epi16(down, _mm256_xor_si256(quad, _mm256_set1_epi8(-128)));
    const Ints f = fixed_u & 4095;
    const Ints across = (f << 16) - f + 4096;  // (4096 - f, f) for the two columns
    return _mm256_cvtepi32_ps(_mm256_madd_epi16(columns, wide(across)));
#else
    const Ints quad = load_quads(image, (fixed_v >> 12) * static_cast<int>(image.stride) + (fixed_u >> 12));
    const Ints fu = fixed_u & 4095;
    const Ints fv = (fixed_v >> 4) & 255;
    const Ints first = (quad & 255) * (255 - fv) + ((quad >> 8) & 255) * fv;
    const Ints second = ((quad >> 16) & 255) * (255 - fv) + ((quad >> 24) & 255) * fv;
    return to_floats(first * (4096 - fu) + second * fu - 128 * 255 * 4096);
#endif
}

}  // namespace facet::simd
