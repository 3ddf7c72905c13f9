// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/image_check.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>

namespace facet {
namespace {

constexpr int kDarkGrey = 12;
constexpr int kBrightGrey = 245;
constexpr double kMostAtAnEnd = 0.9;    // share of pixels
constexpr double kLeastContrast = 2.0;  // standard deviation (grey values)

}  // namespace

ImageState check_image(const ImageView& coarse) {
    std::int64_t sum = 0;
    std::int64_t squares = 0;
    std::int64_t dark = 0;
    std::int64_t bright = 0;
    for (int y = 0; y < coarse.height; ++y) {
        const std::uint8_t* row = coarse.data + static_cast<std::ptrdiff_t>(y) * coarse.stride;
        for (int x = 0; x < coarse.width; ++x) {
            const int grey = row[x];
            sum += grey;
            squares += grey * grey;
            dark += grey < kDarkGrey ? 1 : 0;
            bright += grey > kBrightGrey ? 1 : 0;
        }
    }
    const double count = static_cast<double>(coarse.width) * coarse.height;
    if (static_cast<double>(dark) > kMostAtAnEnd * count) {
        return ImageState::kDark;
    }
    if (static_cast<double>(bright) > kMostAtAnEnd * count) {
        return ImageState::kOverexposed;
    }
    const double mean = static_cast<double>(sum) / count;
    const double variance = static_cast<double>(squares) / count - mean * mean;
    return variance < kLeastContrast * kLeastContrast ? ImageState::kFlat : ImageState::kUsable;
}

bool is_same_image(const ImageView& a, const ImageView& b) {
    constexpr int kRowStep = 16;
    for (int y = 0; y < a.height; y += kRowStep) {
        const std::uint8_t* row_a = a.data + static_cast<std::ptrdiff_t>(y) * a.stride;
        const std::uint8_t* row_b = b.data + static_cast<std::ptrdiff_t>(y) * b.stride;
        if (!std::equal(row_a, row_a + a.width, row_b)) {
            return false;
        }
    }
    return true;
}

double relative_contrast(const ImageView& image) {
    constexpr int kRowStep = 8;
    std::int64_t differences = 0;
    std::int64_t sum = 0;
    for (int y = 0; y < image.height; y += kRowStep) {
        const std::uint8_t* row = image.row(y);
        int row_differences = 0;
        int row_sum = 0;
        for (int x = 2; x < image.width; ++x) {
            row_differences += std::abs(row[x] - row[x - 2]);
            row_sum += row[x];
        }
        differences += row_differences;
        sum += row_sum;
    }
    return sum > 0 ? static_cast<double>(differences) / static_cast<double>(sum) : 0.0;
}

}  // namespace facet
