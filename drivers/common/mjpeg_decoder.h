// SPDX-License-Identifier: BSD-2-Clause
// The JPEGs of a camera to 8-bit grey, without heap.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "platform/base/status.h"

namespace facet {

/// Memory that is given out from its front and taken back as a whole. Thread-bound. Heap in the constructor only.
class JpegArena {
public:
    explicit JpegArena(std::size_t size) : size_(size), bytes_(std::make_unique<std::byte[]>(size + kAlignment)) {}
    /// Aligned to kAlignment, as the SIMD code of libjpeg-turbo needs it. @return nullptr if it is used up
    void* take(std::size_t size);
    void clear() { used_ = 0; }

    static constexpr std::size_t kAlignment = 64;

private:
    std::size_t size_;
    std::unique_ptr<std::byte[]> bytes_;
    std::size_t used_ = 0;
};

struct MjpegState;  ///< libjpeg's objects

/// Baseline JPEGs of one scan, as cameras send them (UVC "Motion-JPEG"), also those that leave out the Huffman tables
/// since they are the usual ones. Of a colour image only the luma is decoded. A JPEG is refused that is progressive, of
/// another size, damaged or cut off, however little is missing. Thread-bound. Heap in the constructor only: libjpeg is
/// given memory of ours.
class MjpegDecoder {
public:
    MjpegDecoder(int width, int height);
    ~MjpegDecoder();
    MjpegDecoder(const MjpegDecoder&) = delete;
    MjpegDecoder& operator=(const MjpegDecoder&) = delete;

    /// @param bytes  a JPEG, and whatever lies behind it in its buffer
    /// @param out    width * height bytes, rows without padding; on failure whatever came before the fault
    /// @return kCorrupt if it is refused, with the words in problem()
    Status decode(std::span<const std::uint8_t> bytes, std::span<std::uint8_t> out);
    const char* problem() const { return problem_.data(); }

private:
    const char* read(std::span<const std::uint8_t> bytes, std::span<std::uint8_t> out);

    int width_;
    int height_;
    std::unique_ptr<MjpegState> state_;
    std::array<char, 200> problem_{};
};

}  // namespace facet
