// SPDX-License-Identifier: BSD-2-Clause
// How often position and yaw have jumped since an estimate was given.
#pragma once

#include <cstdint>

namespace facet {

/// Counts the jumps of position and yaw that somebody with an estimate must know of. Thread-bound. No heap.
class ResetCounter {
public:
    /// Position and yaw may have jumped.
    void jump() {
        value_ += has_given_ ? 1U : 0U;
        has_given_ = false;
    }
    /// An estimate to be used has been given.
    void give() { has_given_ = true; }
    std::uint32_t value() const { return value_; }
    /// This program has not given an estimate to be used.
    bool is_first_start() const { return !has_given_ && value_ == 0; }

private:
    std::uint32_t value_ = 0;
    bool has_given_ = false;  ///< since it last rose
};

}  // namespace facet
