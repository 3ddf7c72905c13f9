// SPDX-License-Identifier: BSD-2-Clause
// Four floats at a time through the compiler's vector extension: SSE on x86, NEON on ARM, no intrinsics.
#pragma once

#include <cmath>
#include <cstdint>

namespace facet::sim {

using F4 = float __attribute__((vector_size(16)));
using I4 = std::int32_t __attribute__((vector_size(16)));

inline constexpr int kLanes = 4;

inline F4 splat(float x) { return F4{x, x, x, x}; }
inline F4 min4(F4 a, F4 b) { return a < b ? a : b; }
inline F4 max4(F4 a, F4 b) { return a > b ? a : b; }
inline F4 sqrt4(F4 a) { return F4{std::sqrt(a[0]), std::sqrt(a[1]), std::sqrt(a[2]), std::sqrt(a[3])}; }

/// True if any lane of a comparison's mask is set.
inline bool any(I4 mask) {
    using L2 = long long __attribute__((vector_size(16)));
    const L2 halves = reinterpret_cast<L2>(mask);
    return (halves[0] | halves[1]) != 0;
}

/// Three coordinates of four points or directions.
struct V4 {
    F4 x;
    F4 y;
    F4 z;
};

inline V4 operator+(const V4& a, const V4& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline V4 operator-(const V4& a, const V4& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline V4 operator*(F4 s, const V4& a) { return {s * a.x, s * a.y, s * a.z}; }
inline F4 dot(const V4& a, const V4& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
/// Dot product of four vectors with one, v[0..2].
inline F4 dot(const float* v, const V4& a) { return v[0] * a.x + v[1] * a.y + v[2] * a.z; }

}  // namespace facet::sim
