// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/check/free_matches.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "estimator/frontend/simd.h"

namespace facet {
namespace {

constexpr int kMostLevels = 4;
constexpr int kSearchLevel = 2;
constexpr int kHalf = 4;  // of the template of the search, on its level
constexpr int kSide = 2 * kHalf + 1;
constexpr float kMinCorrelation = 0.8F;
constexpr float kMinLead = 0.05F;  // of the best place over any other
constexpr int kApart = 2;          // px of the search's level: another place
constexpr double kBackwardPx = 0.3;
constexpr int kStereoCorners = 120;
constexpr int kFollowCorners = 120;
constexpr int kWindowPx = 15;

/// Normalised template at (u, v): zero mean, unit norm. @return false outside the image or without texture
bool cut_template(const ImageView& image, int u, int v, float* out) {
    if (u < kHalf || v < kHalf || u + kHalf >= image.width || v + kHalf >= image.height) {
        return false;
    }
    float sum = 0.0F;
    float squares = 0.0F;
    float* p = out;
    for (int row = -kHalf; row <= kHalf; ++row) {
        const std::uint8_t* pixels = image.row(v + row) + u - kHalf;
        for (int i = 0; i < kSide; ++i) {
            const auto grey = static_cast<float>(pixels[i]);
            *p++ = grey;
            sum += grey;
            squares += grey * grey;
        }
    }
    constexpr float kCount = kSide * kSide;
    const float mean = sum / kCount;
    const float energy = squares - sum * mean;
    if (energy < 4.0F * kCount) {
        return false;
    }
    const float scale = 1.0F / std::sqrt(energy);
    std::for_each(out, out + kSide * kSide, [&](float& x) { x = (x - mean) * scale; });
    return true;
}

/// Sums of a normalised template's products with simd::kLanes places, (u, v) and those to its right, each in the order
/// of the pixels. Places beyond the last one inside are of no use, but may be read.
simd::Floats products_at(const ImageView& image, int u, int v, const float* pattern) {
    simd::Floats product{};
    for (int row = -kHalf; row <= kHalf; ++row) {
        const std::uint8_t* const pixels = image.row(v + row) + u - kHalf;
        for (int i = 0; i < kSide; ++i) {
            product += simd::load_bytes(pixels + i) * simd::splat(*pattern++);
        }
    }
    return product;
}

CornerList corners_of(Detector& detector, const ImageView& image, int wanted) {
    CornerList corners;
    detector.detect(image, {}, wanted, corners);
    return corners;
}

}  // namespace

Status FreeMatcher::configure(int width, int height) {
    FrontendConfig config;
    config.max_features = kStereoCorners;
    levels_ = kMostLevels;
    if (!ok(first_.configure(width, height, levels_))) {
        levels_ = kSearchLevel + 1;
        FACET_TRY(first_.configure(width, height, levels_));
    }
    FACET_TRY(second_.configure(width, height, levels_));
    FACET_TRY(aligner_.configure(kWindowPx, levels_, 30, 0.01));
    aligner_.allocate(patch_);
    aligner_.allocate(back_);
    // No calibration is trusted here: a plain pinhole, whose image has corners everywhere.
    const double focal_px = width;
    detector_.configure(config, CameraModel({width, height, focal_px, focal_px, 0.5 * width, 0.5 * height, {}, {}}),
                        aligner_.border_px());
    template_.resize(kSide * kSide);
    followed_.clear();
    return Status::kOk;
}

/// The energy about its mean of the surroundings of each place of an image that has all of them.
void FreeMatcher::measure_energy(const ImageView& image) {
    // Differences of integrals over the corners' products are right even where the integrals themselves wrap round.
    const auto columns = static_cast<std::size_t>(image.width) + 1;
    integral_.assign(columns * (static_cast<std::size_t>(image.height) + 1), {});
    for (int v = 0; v < image.height; ++v) {
        const std::uint8_t* const pixels = image.row(v);
        const GreySums* const above = integral_.data() + static_cast<std::size_t>(v) * columns;
        GreySums* const at = integral_.data() + static_cast<std::size_t>(v + 1) * columns;
        GreySums row;
        for (int u = 0; u < image.width; ++u) {
            const std::uint32_t grey = pixels[u];
            row.grey += grey;
            row.squares += grey * grey;
            at[u + 1] = {above[u + 1].grey + row.grey, above[u + 1].squares + row.squares};
        }
    }
    energy_.assign(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height), 0.0F);
    for (int v = kHalf; v + kHalf < image.height; ++v) {
        const GreySums* const top = integral_.data() + static_cast<std::size_t>(v - kHalf) * columns;
        const GreySums* const bottom = top + kSide * columns;
        for (int u = kHalf; u + kHalf < image.width; ++u) {
            const int l = u - kHalf;
            const int r = l + kSide;
            const auto sum = static_cast<float>(bottom[r].grey - bottom[l].grey - top[r].grey + top[l].grey);
            const auto squares =
                static_cast<float>(bottom[r].squares - bottom[l].squares - top[r].squares + top[l].squares);
            energy_[static_cast<std::size_t>(v * image.width + u)] = squares - sum * sum / (kSide * kSide);
        }
    }
}

bool FreeMatcher::search(const Eigen::Vector2d& corner, const ImageView& left, const ImageView& right,
                         Eigen::Vector2d& found) {
    const int scale = 1 << kSearchLevel;
    const int u0 = static_cast<int>(std::lround(corner.x() / scale));
    const int v0 = static_cast<int>(std::lround(corner.y() / scale));
    if (!cut_template(left, u0, v0, template_.data())) {
        return false;
    }
    const int reach_u = left.width / 3;
    const int reach_v = left.height / 6;
    const int last_u = std::min(right.width - 1 - kHalf, u0 + reach_u);
    struct Place {
        int u;
        int v;
        float score;
    };
    std::vector<Place> places;
    Place best{0, 0, 0.0F};
    for (int v = std::max(kHalf, v0 - reach_v); v <= std::min(right.height - 1 - kHalf, v0 + reach_v); ++v) {
        const float* const energy = energy_.data() + static_cast<std::ptrdiff_t>(v) * right.width;
        for (int first = std::max(kHalf, u0 - reach_u); first <= last_u; first += simd::kLanes) {
            const simd::Floats product = products_at(right, first, v, template_.data());
            for (int u = first; u <= std::min(last_u, first + simd::kLanes - 1); ++u) {
                const float score = energy[u] > 0.0F ? product[u - first] / std::sqrt(energy[u]) : 0.0F;
                if (score > kMinCorrelation - kMinLead) {
                    places.push_back({u, v, score});
                    best = score > best.score ? places.back() : best;
                }
            }
        }
    }
    const bool is_unique = std::ranges::none_of(places, [&](const Place& p) {
        const bool is_other = std::abs(p.u - best.u) > kApart || std::abs(p.v - best.v) > kApart;
        return is_other && p.score > best.score - kMinLead;
    });
    found = Eigen::Vector2d(best.u, best.v) * scale;
    return best.score >= kMinCorrelation && is_unique;
}

bool FreeMatcher::align_both_ways(const ImagePyramid& from, const ImagePyramid& to, int coarsest, PointPair& pair) {
    const ExtractOptions extract{.coarsest = coarsest, .affine = false};
    const AlignOptions align{.coarsest = coarsest};
    float correlation = 0.0F;
    PatchPose there{.uv = pair.second};
    if (!ok(aligner_.extract(from, pair.first, extract, patch_)) ||
        !ok(aligner_.align(patch_, to, align, there, correlation)) ||
        !ok(aligner_.extract(to, there.uv, extract, back_))) {
        return false;
    }
    PatchPose again{.uv = pair.first};
    if (!ok(aligner_.align(back_, from, align, again, correlation)) || (again.uv - pair.first).norm() > kBackwardPx) {
        return false;
    }
    pair.second = there.uv;
    return true;
}

std::vector<PointPair> FreeMatcher::match_stereo(const ImageView& left, const ImageView& right) {
    first_.build(left);
    second_.build(right);
    measure_energy(second_.level(kSearchLevel));
    followed_.clear();
    std::vector<PointPair> pairs;
    for (const Eigen::Vector2d& corner : corners_of(detector_, left, kStereoCorners)) {
        PointPair pair{corner, corner};
        if (search(corner, first_.level(kSearchLevel), second_.level(kSearchLevel), pair.second) &&
            align_both_ways(first_, second_, 1, pair)) {
            pairs.push_back(pair);
        }
    }
    return pairs;
}

std::vector<PointPair> FreeMatcher::follow(const ImageView& now, bool starts_anew) {
    second_.build(now);
    std::vector<PointPair> kept;
    for (const PointPair& old : followed_) {
        PointPair step{old.second, old.second};
        if (align_both_ways(first_, second_, levels_ - 1, step)) {
            kept.push_back({old.first, step.second});
        }
    }
    followed_ = kept;
    std::swap(first_, second_);
    if (starts_anew) {
        followed_.clear();
        for (const Eigen::Vector2d& corner : corners_of(detector_, now, kFollowCorners)) {
            followed_.push_back({corner, corner});
        }
    }
    return kept;
}

double mean_difference(const ImageView& a, const ImageView& b) {
    double sum = 0.0;
    for (int v = 0; v < a.height; ++v) {
        for (int u = 0; u < a.width; ++u) {
            sum += std::abs(static_cast<int>(a.at(u, v)) - static_cast<int>(b.at(u, v)));
        }
    }
    return sum / (static_cast<double>(a.width) * a.height);
}

double mean_grey(const ImageView& image) {
    double sum = 0.0;
    for (int v = 0; v < image.height; ++v) {
        for (int u = 0; u < image.width; ++u) {
            sum += image.at(u, v);
        }
    }
    return sum / (static_cast<double>(image.width) * image.height);
}

}  // namespace facet
