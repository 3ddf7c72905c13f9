// SPDX-License-Identifier: BSD-2-Clause
// Where an image shows the vehicle itself: no corner is taken there, and no stereo match.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "platform/base/image_view.h"
#include "platform/base/status.h"
#include "platform/base/timestamp.h"

namespace facet {

/// Two layers: what the user has drawn, for good, and what has been found to move with the vehicle, in blocks of
/// kBlock_px that are forgotten after kMemory_s, so that a mistake heals. Heap: in configure() only. Thread-bound.
class PixelMask {
public:
    static constexpr int kBlock_px = 8;
    /// A pattern that stays is found again in about a second; a part of the world wrongly taken for one is missed for
    /// this long.
    static constexpr double kMemory_s = 20.0;
    /// Outliers of the world hardly ever stand still at one place so often.
    static constexpr int kStrikes = 3;

    /// Nothing is covered.
    void configure(int width, int height);
    /// Pixels of `drawn` that are zero are covered; an empty view covers nothing.
    /// @return kInvalidArgument on another size (nothing changed)
    Status draw(const ImageView& drawn);

    /// Forgets what has been found, not what is drawn.
    void forget();
    /// The block around a pixel moves with the vehicle.
    void cover(const Eigen::Vector2d& uv, Timestamp now);
    /// It seems to: covered at the kStrikes-th time within kMemory_s from one to the next.
    void suspect(const Eigen::Vector2d& uv, Timestamp now);
    bool is_drawn(const Eigen::Vector2d& uv) const;
    /// Writes 1 for each covered pixel and 0 for the others, row by row. @param flags  width x height or more
    void write(Timestamp now, std::span<std::uint8_t> flags) const;
    /// Share of the image that is covered by what has been found.
    double found_share(Timestamp now) const;

private:
    struct Block {
        std::int64_t until = 0;  ///< ns
        int strikes = 0;         ///< until then; covered from kStrikes on
    };

    bool is_covered(std::size_t block, Timestamp now) const {
        return blocks_[block].strikes >= kStrikes && blocks_[block].until > now.ns;
    }
    void add(const Eigen::Vector2d& uv, Timestamp now, int strikes);
    std::size_t block_of(int u, int v) const;
    Eigen::Vector2i pixel_of(const Eigen::Vector2d& uv) const;

    int width_ = 0;
    int height_ = 0;
    int columns_ = 0;
    std::vector<bool> drawn_;   ///< whether a pixel is covered
    bool has_drawing_ = false;  ///< any is
    std::vector<Block> blocks_;
    std::int64_t last_until_ = 0;  ///< the latest of them
};

}  // namespace facet
