// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/replay_asl/png_arena.h"

#include <algorithm>
#include <cstdlib>
#include <functional>

namespace facet {

void PngArena::reset() {
    if (wanted_ > capacity_ && capacity_ < kMaxBytes) {
        capacity_ = std::min(wanted_, kMaxBytes);
        block_ = std::make_unique_for_overwrite<std::byte[]>(capacity_);
    }
    used_ = 0;
    wanted_ = 0;
}

void* PngArena::allocate(std::size_t size) {
    constexpr std::size_t kAlignment = alignof(std::max_align_t);
    if (size > kMaxBytes) {
        return std::malloc(size);
    }
    const std::size_t padded = (std::max(size, std::size_t{1}) + kAlignment - 1) / kAlignment * kAlignment;
    wanted_ += padded;
    if (padded > capacity_ - used_) {
        return std::malloc(size);
    }
    void* const piece = block_.get() + used_;
    used_ += padded;
    return piece;
}

void PngArena::free(void* piece) {
    if (!owns(piece)) {
        std::free(piece);
    }
}

bool PngArena::owns(const void* piece) const {
    const std::less<const void*> before;
    return block_ != nullptr && !before(piece, block_.get()) && before(piece, block_.get() + capacity_);
}

}  // namespace facet
