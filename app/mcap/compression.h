// SPDX-License-Identifier: BSD-2-Clause
// What the chunks of recorded files are compressed with.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "platform/base/status.h"

namespace facet {

enum class Compression : std::uint8_t { kNone, kLz4, kZstd, kBz2 };

/// "none" (and "", as MCAP writes it), "lz4" (frames), "zstd", "bz2"; empty if it is another name.
std::optional<Compression> find_compression(std::string_view name);

/// Appends to `out`. kNone, kLz4 and kZstd at their quickest levels; bz2 is only read. Reentrant. Heap. Throws
/// std::runtime_error if the library fails, which lack of memory alone can cause.
void compress(Compression method, std::string_view in, std::string& out);

/// Most that the parts of a file of so many bytes may unpack to, all together: a gigabyte, and a thousand times the
/// file. Recordings of darkness are the most compressible ones there are; what goes beyond was made to keep its reader
/// busy.
constexpr std::uint64_t most_unpacked(std::uint64_t file_bytes) {
    constexpr std::uint64_t kAlways = std::uint64_t{1} << 30U;
    constexpr std::uint64_t kRatio = 1000;
    return file_bytes > (UINT64_MAX - kAlways) / kRatio ? UINT64_MAX : kAlways + kRatio * file_bytes;
}

/// Replaces `out`, whose storage is reused and grows with what is really there, not with what `size` states. Reentrant.
/// @return kCorrupt unless the bytes are whole and hold exactly `size` bytes; `out` is then of no use
Status decompress(Compression method, std::span<const std::uint8_t> in, std::size_t size,
                  std::vector<std::uint8_t>& out);

/// By how a frame begins: kZstd, kLz4, or kNone if it is neither's.
Compression compression_of(std::span<const std::uint8_t> begin);

/// decompress() of zstd and lz4 without knowing the size.
/// @return kCorrupt also if it is more than `most_bytes`
Status decompress_frame(std::span<const std::uint8_t> in, std::size_t most_bytes, std::vector<std::uint8_t>& out);

}  // namespace facet
