// SPDX-License-Identifier: BSD-2-Clause
// A keyframe as mesh and planes need it, at its own frame or two frames later.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "estimator/geometry/stereo_rig.h"
#include "platform/base/samples.h"

namespace facet {

/// What its view does not say.
struct MappedKeyframe {
    StereoFrame frame;                ///< as given to the estimator
    Timestamp estimate_stamp;         ///< of its estimate, as given out
    std::uint32_t reset_counter = 0;  ///< of its health
};

/// Keeps one with copies of its images. Thread-bound. Heap in configure() only.
class KeptKeyframe {
public:
    /// Keeps none.
    void configure(const StereoRig& rig);
    void keep(const MappedKeyframe& keyframe);
    void drop() { is_set_ = false; }
    bool is_set() const { return is_set_; }
    /// Its images outlast one more keep().
    const MappedKeyframe& get() const { return keyframe_; }

private:
    using Pixels = std::vector<std::uint8_t>;
    struct Pair {
        Pixels left;
        Pixels right;
    };

    MappedKeyframe keyframe_;
    std::array<Pair, 2> pairs_;  ///< the first one is the newest
    bool is_set_ = false;
};

}  // namespace facet
