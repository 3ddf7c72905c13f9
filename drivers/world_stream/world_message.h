// SPDX-License-Identifier: BSD-2-Clause
// Messages that bring a WorldState from one keyframe to a later one.
//
// All numbers are little-endian. A message is a header of kWorldHeaderBytes and a payload:
//   header   u32 magic, u16 version, u16 0, u32 bytes of the payload, u64 base, u64 sequence, i64 stamp_ns
//   payload  u32 resets, f64 cell_m, i32 low[3], u16 tick
//            u16 n, n planes            u32 id, f32 normal[3], f32 distance       all planes, not only new ones
//            u16 n, n vertices          u16 index, f32 p_W[3]                     new or moved
//            u16 n, n faces gone        u16 index
//            u16 n, n faces             u16 index, u16 vertex[3], u16 observations, u32 plane, f32 sigma, u8 is_fill
//            u16 n, n blocks of cells   u16 index, u8 cells[kWorldBlockBytes], u8 levels[kWorldBlockBytes],
//                                       u16 confirmed[kWorldBlockRuns]            changed
// It applies to the state whose sequence is `base`; base 0 is the empty state: such a message is a full snapshot.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/world_stream/world_state.h"
#include "platform/base/status.h"

namespace facet {

inline constexpr std::uint32_t kWorldMagic = 0x54434146;  ///< "FACT"
inline constexpr std::uint16_t kWorldVersion = 2;
inline constexpr std::size_t kWorldHeaderBytes = 36;
/// No payload is shorter, or longer.
inline constexpr std::size_t kMinWorldPayload = 26 + 5 * 2;
inline constexpr std::size_t kMaxWorldPayload =
    kMinWorldPayload + std::size_t{kWorldPlanes} * 20 + std::size_t{kWorldVertices} * 14 +
    std::size_t{kWorldFaces} * 19 + std::size_t{kWorldBlocks} * (2 + 2 * kWorldBlockBytes + 2 * kWorldBlockRuns);

/// Replaces `message` by what leads from `base` to `state`. No heap if it has the capacity of the longest message.
/// @param base  the state that the reader has; nullptr: none, a snapshot. Contract: its sequence is not 0.
void encode_world(const WorldState* base, const WorldState& state, std::vector<std::uint8_t>& message);

/// Bytes of the payload that follows a header.
/// @return kCorrupt if these are not the first kWorldHeaderBytes of a message of this version, or its length cannot be
Status world_payload_bytes(std::span<const std::uint8_t> header, std::size_t& bytes);

/// Brings a state up to date with a whole message. On anything but kOk the state is untouched.
/// @return kOutOfOrder if the message does not apply to this state; kCorrupt if it is no valid message
Status apply_world(std::span<const std::uint8_t> message, WorldState& state);

}  // namespace facet
