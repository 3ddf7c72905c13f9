// SPDX-License-Identifier: BSD-2-Clause
// Depth of all of an image's squares, from the depths that are known outward.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mesh/volume/depth_samples.h"

namespace facet {

/// The depth of a square, as landmarks have it.
struct DepthSeed {
    int square = 0;
    float inverse_depth = 0.0F;
};

/// Region growing as in [Cech07]: a square is searched near the depths of the squares around it as soon as one of them
/// is known, and what is found goes on to its own neighbours. Only where nothing is known near by, where the depths
/// around differ too much to lie on one surface, or where searching near a few of them was in vain, all depths are
/// searched: that takes ten times as long. Not so amid squares where this has found nothing either, as on bare walls.
/// Heap in the constructor only. Thread-bound. Deterministic.
class DepthGrowth {
public:
    /// @param sampler  borrowed
    explicit DepthGrowth(DepthSampler& sampler);

    /// Forgets the image before.
    void begin(std::span<const DepthSeed> seeds);
    /// Measures the next square: `samples`, one a square, are those of this image since begin().
    /// @return the places along epipolar lines that were compared; negative: all squares are done
    int advance(const ImagePyramid& left, const ImagePyramid& right, std::span<DepthSample> samples);

private:
    enum class State : std::uint8_t {
        kNew,
        kQueued,  ///< to be searched near its neighbours' depths
        kMissed,  ///< which was in vain with a few of them
        kInVain,  ///< all depths were searched, or near those of many
        kKnown,
        kLeftOut,  ///< without texture, or amid squares that were searched in vain
    };
    struct Surroundings {
        int known = 0;
        int in_vain = 0;
        DepthRange range;  ///< of those known
    };

    Surroundings around(int square, std::span<const DepthSample> samples) const;
    int grow(int square, const ImagePyramid& left, const ImagePyramid& right, std::span<DepthSample> samples);
    int search(int square, const ImagePyramid& left, const ImagePyramid& right, std::span<DepthSample> samples);
    int match(int square, const DepthRange& range, const ImagePyramid& left, const ImagePyramid& right,
              std::span<DepthSample> samples);
    template <class Visit>
    void visit_around(int square, const Visit& visit) const;
    State& state(int square) { return states_[static_cast<std::size_t>(square)]; }

    DepthSampler& sampler_;
    int stride_ = 1;  ///< from square to square where nothing is known: soon everywhere in the image
    std::vector<State> states_;
    std::vector<float> seeds_;  ///< inverse depths, or 0
    std::vector<int> queue_;    ///< a square may come in twice
    std::size_t next_queued_ = 0;
    int next_ = 0;
};

}  // namespace facet
