// SPDX-License-Identifier: BSD-2-Clause
// Memory for libpng that is kept from image to image.
#pragma once

#include <cstddef>
#include <memory>

namespace facet {

/// What libpng and zlib allocate while an image is decoded is handed out here one piece behind the other and taken back
/// all at once. What does not fit comes from the heap, and the arena has room for it from the next image on: images of
/// one kind make no heap call after the first. It grows up to kMaxBytes, more than images of any size need unless they
/// are interlaced or carry large annotations. Thread-bound. Heap: as said.
class PngArena {
public:
    static constexpr std::size_t kMaxBytes = std::size_t{1} << 20U;

    /// Takes everything back: call it when nothing handed out is in use any longer.
    void reset();

    /// `size` bytes, aligned for any object; nullptr if the heap has none.
    void* allocate(std::size_t size);

    /// Frees what came from the heap, nothing else.
    void free(void* piece);

private:
    bool owns(const void* piece) const;

    std::unique_ptr<std::byte[]> block_;
    std::size_t capacity_ = 0;
    std::size_t used_ = 0;
    std::size_t wanted_ = 0;  // by the present image
};

}  // namespace facet
