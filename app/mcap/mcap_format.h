// SPDX-License-Identifier: BSD-2-Clause
// Numbers of the MCAP format, version 0, as its specification (mcap.dev/spec) has them.
#pragma once

#include <zlib.h>

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>

namespace facet {

inline constexpr std::string_view kMcapMagic{"\x89MCAP0\r\n", 8};

enum class McapOp : std::uint8_t {
    kHeader = 0x01,
    kFooter = 0x02,
    kSchema = 0x03,
    kChannel = 0x04,
    kMessage = 0x05,
    kChunk = 0x06,
    kMessageIndex = 0x07,
    kChunkIndex = 0x08,
    kAttachment = 0x09,
    kAttachmentIndex = 0x0A,
    kStatistics = 0x0B,
    kMetadata = 0x0C,
    kMetadataIndex = 0x0D,
    kSummaryOffset = 0x0E,
    kDataEnd = 0x0F,
};

inline constexpr std::size_t kMcapRecordHead = 9;  ///< bytes: kind and length
inline constexpr std::size_t kMcapMessageHead = 2 + 4 + 8 + 8;

using McapTexts = std::map<std::string, std::string>;

/// CRC-32 of what a checksum covers so far and of these bytes behind it; begins with 0.
inline std::uint32_t crc_of(std::span<const std::uint8_t> bytes, std::uint32_t before = 0) {
    return static_cast<std::uint32_t>(crc32_z(before, bytes.data(), bytes.size()));
}

}  // namespace facet
