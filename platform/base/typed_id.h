// SPDX-License-Identifier: BSD-2-Clause
// Integer ids that cannot be mixed up: one distinct type per kind of thing.
#pragma once

#include <compare>
#include <cstdint>

namespace facet {

/// An id of the kind named by Tag. Default-constructed ids are invalid. Ids are handed out in increasing order and are
/// never used again within a run. Reentrant. No heap.
template <class Tag>
struct TypedId {
    static constexpr std::uint32_t kInvalid = 0xffffffffU;

    std::uint32_t value = kInvalid;

    constexpr bool valid() const { return value != kInvalid; }
    constexpr auto operator<=>(const TypedId&) const = default;
};

using LandmarkId = TypedId<struct LandmarkTag>;  ///< one tracked point, from its first to its last observation
using PlaneId = TypedId<struct PlaneTag>;        ///< one plane of the mesh

}  // namespace facet
