// SPDX-License-Identifier: BSD-2-Clause
// The map's surface as browsers are sent it: what has changed since they were sent it last.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>

#include "mesh/volume/surface_map.h"

namespace facet {

/// Keeps the newest piece of each block, packed as it is sent (little-endian):
///   int32 x, y, z of the block's corner (0.1 mm), int32 vertices n, int32 triangles m,
///   n times: int16 x, y, z from that corner (0.1 mm), int8 normal x, y, z (1/127), uint8 grey,
///   m times: uint16 a, b, c, counterclockwise as seen from free space,
///   zeros up to a multiple of four bytes.
/// A piece without triangles says that the block's surface is gone. A restart of the map begins a new surface. Beyond
/// kMaxBytes new blocks are left out and counted. Thread-safe. Heap.
class LiveSurface final : public SurfaceSink {
public:
    static constexpr std::size_t kMaxBytes = 64U << 20U;

    /// What a browser has.
    struct Position {
        std::uint32_t surface = 0;  ///< which one; 0: none
        std::uint64_t version = 0;
        friend bool operator==(const Position&, const Position&) = default;
    };

    void take(const SurfacePiece& piece, std::uint32_t restart) override;

    /// Appends the pieces that have changed since `position`, those first that changed longest ago, until there are
    /// `bytes` of them, and moves it there.
    /// @return whether there were any, or the browser's surface is no longer the present one
    bool append_changes(Position& position, std::size_t bytes, std::string& body) const;

    std::uint64_t dropped() const;

private:
    using Key = std::array<std::int32_t, 3>;
    struct Piece {
        std::uint64_t version = 0;
        std::string packed;
    };

    mutable std::mutex mutex_;
    std::uint32_t surface_ = 1;
    std::uint32_t restart_ = 0;
    std::uint64_t version_ = 0;
    std::size_t bytes_ = 0;
    std::uint64_t dropped_ = 0;
    std::map<Key, Piece> pieces_;
    std::map<std::uint64_t, Key> by_version_;
};

}  // namespace facet
