// SPDX-License-Identifier: BSD-2-Clause
// Why the window shall restart at the next frame that allows it.
#pragma once

#include <cstdint>

namespace facet {

enum class RestartReason : std::uint8_t {
    kUser = 1U << 0U,         ///< Estimator::request_reset()
    kLandmarkIds = 1U << 1U,  ///< they have been used up
    kLostTime = 1U << 2U,     ///< time has passed that is on no clock
};

/// Thread-bound. No heap.
class RestartRequests {
public:
    void add(RestartReason reason) { reasons_ = static_cast<std::uint8_t>(reasons_ | static_cast<unsigned>(reason)); }
    bool any() const { return reasons_ != 0; }
    void clear() { reasons_ = 0; }

private:
    std::uint8_t reasons_ = 0;
};

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
