// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/detector.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>

#include "estimator/frontend/simd.h"
#include "platform/base/assert.h"

namespace facet {
namespace {

constexpr float kMinScore = 1e-5F;  // about 1.3 grey levels a pixel

/// True if all of the next kLanes flags, each 0 or 1, are 1.
bool all_set(const std::uint8_t* flags) {
    constexpr std::uint64_t kOnes = 0x0101010101010101U >> (64 - 8 * simd::kLanes);
    std::uint64_t bytes = 0;
    std::memcpy(&bytes, flags, simd::kLanes);
    return bytes == kOnes;
}

}  // namespace

void Detector::configure(const FrontendConfig& config, const CameraModel& camera, double border_px) {
    const int width = camera.intrinsics().width;
    const int height = camera.intrinsics().height;
    config_ = config;
    width_ = width;
    height_ = height;
    const int border = std::max(CornerScore::kReach + 1, static_cast<int>(std::ceil(border_px)));
    begin_.assign(static_cast<std::size_t>(height), 0);
    end_.assign(static_cast<std::size_t>(height), 0);
    for (int v = border; v < height - border; ++v) {
        int first = border;
        int last = width - border;
        while (first < last && !camera.in_lens(Eigen::Vector2d(first, v), border)) {
            ++first;
        }
        while (first < last && !camera.in_lens(Eigen::Vector2d(last - 1, v), border)) {
            --last;
        }
        begin_[static_cast<std::size_t>(v)] = first;
        end_[static_cast<std::size_t>(v)] = last;
    }
    const std::size_t area = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    const std::size_t cells =
        static_cast<std::size_t>(config.corners.columns) * static_cast<std::size_t>(config.corners.rows);
    score_.configure(width, height);
    blocked_.assign(area + simd::kOverread, 0);
    column_of_.resize(static_cast<std::size_t>(width));
    for (int u = 0; u < width; ++u) {
        column_of_[static_cast<std::size_t>(u)] = u * config.corners.columns / width;
    }
    row_of_.resize(static_cast<std::size_t>(height));
    for (int v = 0; v < height; ++v) {
        row_of_[static_cast<std::size_t>(v)] = v * config.corners.rows / height;
    }
    candidates_.assign(cells * kPerCell, Candidate{});
    count_.assign(cells, 0);
    next_.assign(cells, 0);
    tracks_.assign(cells, 0);
    order_.assign(cells, 0);
    const int reach = static_cast<int>(std::ceil(config.corners.min_distance_px)) - 1;
    disc_.clear();
    for (int dv = -reach; dv <= reach; ++dv) {
        // Strictly nearer than the distance is blocked.
        const double rest =
            config.corners.min_distance_px * config.corners.min_distance_px - static_cast<double>(dv) * dv;
        disc_.push_back(std::max(0, static_cast<int>(std::ceil(std::sqrt(rest))) - 1));
    }
}

int Detector::cell_of(int u, int v) const {
    return row_of_[static_cast<std::size_t>(v)] * config_.corners.columns + column_of_[static_cast<std::size_t>(u)];
}

void Detector::occupy(const Eigen::Vector2d& uv) {
    const int reach = static_cast<int>(disc_.size()) / 2;
    const int cu = static_cast<int>(std::lround(uv.x()));
    const int cv = static_cast<int>(std::lround(uv.y()));
    for (int dv = -reach; dv <= reach; ++dv) {
        const int v = cv + dv;
        const int half = disc_[static_cast<std::size_t>(dv + reach)];
        const int first = std::max(0, cu - half);
        const int last = std::min(width_ - 1, cu + half);
        if (v >= 0 && v < height_ && first <= last) {
            std::fill_n(blocked_.begin() + static_cast<std::ptrdiff_t>(v) * width_ + first, last - first + 1,
                        std::uint8_t{1});
        }
    }
}

void Detector::offer_peaks(int u, int v, int count, float threshold) {
    const std::uint8_t* const blocked = blocked_.data() + static_cast<std::ptrdiff_t>(v) * width_ + u;
    if (all_set(blocked)) {
        return;
    }
    const float* const row = score_.row(v) + u;
    const simd::Floats s = simd::load(row);
    if (!simd::any(s >= threshold)) {  // nearly everywhere
        return;
    }
    const float* const up = score_.row(v - 1) + u;
    const float* const down = score_.row(v + 1) + u;
    // Ties go to the first in reading order.
    const simd::Ints peak = (s >= threshold) & (s > simd::load(row - 1)) & (s >= simd::load(row + 1)) &
                            (s > simd::load(up - 1)) & (s > simd::load(up)) & (s > simd::load(up + 1)) &
                            (s >= simd::load(down - 1)) & (s >= simd::load(down)) & (s >= simd::load(down + 1));
    for (unsigned lanes = simd::lanes_of(peak); lanes != 0; lanes &= lanes - 1) {
        const int i = std::countr_zero(lanes);
        if (i < count && blocked[i] == 0) {
            offer(u + i, v, row[i]);
        }
    }
}

void Detector::offer(int u, int v, float score) {
    const std::size_t cell = static_cast<std::size_t>(cell_of(u, v));
    Candidate* list = candidates_.data() + cell * kPerCell;
    int& n = count_[cell];
    if (n == kPerCell && !(score > list[n - 1].score)) {
        return;
    }
    int at = n < kPerCell ? n++ : n - 1;
    for (; at > 0 && list[at - 1].score < score; --at) {
        list[at] = list[at - 1];
    }
    list[at] = {score, static_cast<std::int16_t>(u), static_cast<std::int16_t>(v)};
}

void Detector::collect(float threshold) {
    std::fill(count_.begin(), count_.end(), 0);
    for (int v = 0; v < height_; ++v) {
        const int end = end_[static_cast<std::size_t>(v)];
        for (int u = begin_[static_cast<std::size_t>(v)]; u < end; u += simd::kLanes) {
            offer_peaks(u, v, std::min(simd::kLanes, end - u), threshold);
        }
    }
}

const Detector::Candidate* Detector::next_free(std::size_t cell) {
    while (next_[cell] < count_[cell]) {
        const Candidate& candidate = candidates_[cell * kPerCell + static_cast<std::size_t>(next_[cell]++)];
        if (blocked_[static_cast<std::size_t>(candidate.v * width_ + candidate.u)] == 0) {
            return &candidate;
        }
    }
    return nullptr;
}

void Detector::detect(const ImageView& image, std::span<const Eigen::Vector2d> occupied, int wanted,
                      CornerList& corners, const PixelMask* mask, Timestamp now) {
    FACET_ASSERT(image.width == width_ && image.height == height_);
    wanted = std::min(wanted, static_cast<int>(corners.capacity() - corners.size()));
    if (wanted <= 0) {
        return;
    }
    if (mask != nullptr) {
        mask->write(now, blocked_);
    } else {
        std::fill(blocked_.begin(), blocked_.end(), std::uint8_t{0});
    }
    std::fill(tracks_.begin(), tracks_.end(), 0);
    for (const Eigen::Vector2d& uv : occupied) {
        occupy(uv);
        const int u = std::clamp(static_cast<int>(uv.x()), 0, width_ - 1);
        const int v = std::clamp(static_cast<int>(uv.y()), 0, height_ - 1);
        ++tracks_[static_cast<std::size_t>(cell_of(u, v))];
    }
    score_.compute(image);
    collect(std::max(kMinScore, static_cast<float>(config_.corners.quality) * score_.best()));

    std::fill(next_.begin(), next_.end(), 0);
    bool progress = true;
    while (wanted > 0 && progress) {
        progress = false;
        std::iota(order_.begin(), order_.end(), 0);
        std::sort(order_.begin(), order_.end(), [this](int a, int b) {
            const int more = tracks_[static_cast<std::size_t>(a)] - tracks_[static_cast<std::size_t>(b)];
            return more < 0 || (more == 0 && a < b);
        });
        for (const int cell : order_) {
            if (wanted == 0) {
                break;
            }
            if (const Candidate* corner = next_free(static_cast<std::size_t>(cell)); corner != nullptr) {
                corners.emplace_back(corner->u, corner->v);
                occupy(corners.back());
                ++tracks_[static_cast<std::size_t>(cell)];
                --wanted;
                progress = true;
            }
        }
    }
}

}  // namespace facet
