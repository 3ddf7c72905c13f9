// SPDX-License-Identifier: BSD-2-Clause
// The pixels of a patch and their weights.
#pragma once

#include <span>
#include <vector>

namespace facet {

/// The disk inside an odd square, row by row, with Gaussian weights; the tail is padded with pixels of weight 0 to a
/// multiple of the vector width. Heap: in configure() only. Reentrant once configured.
class PatchWindow {
public:
    /// One row of the disk: offsets from -half to half of the patch's centre at v; the first is pixel `first`.
    struct Row {
        int v;
        int half;
        int first;
    };
    static constexpr float kMinVariance = 4.0F;   ///< grey levels^2: below, a patch is noise
    static constexpr float kGreyOrigin = 128.0F;  ///< subtracted first: keeps sums of squares small

    /// @param side_px  odd
    void configure(int side_px);

    int side() const { return side_; }
    /// Pixels from the centre to the edge.
    int half() const { return side_ / 2; }
    /// Pixels, padding included.
    int count() const { return static_cast<int>(weights_.size()); }
    const float* u() const { return u_.data(); }
    const float* v() const { return v_.data(); }
    const float* weights() const { return weights_.data(); }
    float weight_sum() const { return weight_sum_; }
    std::span<const Row> rows() const { return rows_; }

    /// Weight of the pixel at an offset from the centre; 0 outside the disk.
    float weight(int u, int v) const;

private:
    int side_ = 0;
    float weight_sum_ = 0.0F;
    std::vector<float> u_;  ///< offsets from the centre (px)
    std::vector<float> v_;
    std::vector<float> weights_;
    std::vector<Row> rows_;
};

}  // namespace facet
