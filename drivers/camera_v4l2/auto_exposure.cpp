// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/camera_v4l2/auto_exposure.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace facet {
namespace {

constexpr double kBrightest = 240.0;  // where the brightest 2 % may lie
constexpr double kDeadBand = 0.08;
constexpr double kLargestStep = 2.0;
constexpr double kSaturatedShare = 0.02;
constexpr double kSaturatedStep = 0.7;
constexpr double kFraction = 256.0;  // of a grey value, as it is shared

std::uint64_t packed(const ExposureSetting& setting) {
    return (static_cast<std::uint64_t>(static_cast<std::uint32_t>(setting.exposure)) << 32U) |
           static_cast<std::uint32_t>(setting.gain);
}

/// @param count  of images: a word changes with every image, however much alike they are
std::uint64_t packed(const Brightness& seen, std::uint32_t count) {
    const auto number = [](double value) { return static_cast<std::uint64_t>(value * kFraction) & 0xFFFFU; };
    return (std::uint64_t{1} << 63U) | (std::uint64_t{count & 0x7FFFU} << 48U) |
           (number(seen.saturated * 255.0) << 32U) | (number(seen.median) << 16U) | number(seen.bright);
}

Brightness unpacked(std::uint64_t word) {
    const auto number = [&](unsigned shift) { return static_cast<double>((word >> shift) & 0xFFFFU) / kFraction; };
    return {number(16), number(0), number(32) / 255.0};
}

}  // namespace

Brightness measure_brightness(const ImageView& image) {
    constexpr int kEvery = 4;  // rows and columns
    std::array<std::uint32_t, 256> histogram{};
    std::uint32_t pixels = 0;
    for (int v = kEvery / 2; v < image.height; v += kEvery) {
        const std::uint8_t* const row = image.row(v);
        for (int u = kEvery / 2; u < image.width; u += kEvery) {
            ++histogram[row[u]];
            ++pixels;
        }
    }
    const auto value_below = [&](double share) {
        const double wanted = share * pixels;
        double below = 0.0;
        for (std::size_t value = 0; value < histogram.size(); ++value) {
            below += histogram[value];
            if (below >= wanted) {
                return static_cast<double>(value);
            }
        }
        return 255.0;
    };
    std::uint32_t saturated = 0;
    for (std::size_t value = 250; value < histogram.size(); ++value) {
        saturated += histogram[value];
    }
    return {value_below(0.5), value_below(0.98), pixels > 0 ? static_cast<double>(saturated) / pixels : 0.0};
}

ExposureSetting next_setting(const AutoExposureOptions& options, const ExposureSetting& now, const Brightness& seen) {
    double scale = options.target / std::max(seen.median, 1.0);
    scale = std::min(scale, kBrightest / std::max(seen.bright, 1.0));
    if (seen.saturated > kSaturatedShare) {  // how far beyond, nobody knows
        scale = std::min(scale, kSaturatedStep);
    }
    scale = std::clamp(scale, 1.0 / kLargestStep, kLargestStep);
    if (std::abs(scale - 1.0) < kDeadBand) {
        return now;
    }
    const double light = static_cast<double>(now.exposure) * now.gain * scale;
    const auto rounded = [](double value, int least, int most) {
        return static_cast<std::int32_t>(std::lround(std::clamp(value, double(least), double(most))));
    };
    ExposureSetting next;
    next.exposure = rounded(light / options.least_gain, options.least_exposure, options.most_exposure);
    next.gain = rounded(light / next.exposure, options.least_gain, options.most_gain);
    return next;
}

SharedExposure::SharedExposure(AutoExposureOptions options) : options_(std::move(options)) {
    const double middle = std::sqrt(static_cast<double>(options_.least_exposure) * options_.most_exposure);
    setting_.store(packed(ExposureSetting{static_cast<std::int32_t>(std::lround(middle)), options_.least_gain}));
    for (Watch& watch : watches_) {
        watch.setting = setting();
    }
}

ExposureSetting SharedExposure::setting() const {
    const std::uint64_t word = setting_.load(std::memory_order_relaxed);
    return {static_cast<std::int32_t>(word >> 32U), static_cast<std::int32_t>(word & 0xFFFFFFFFU)};
}

/// The cameras that live.
struct SharedExposure::Sight {
    std::size_t first = kCameras;
    int cameras = 0;
    Brightness rig;  ///< the mean of the medians, the largest of the others
};

SharedExposure::Sight SharedExposure::look_around(Watch& watch) {
    Sight sight;
    for (std::size_t i = 0; i < kCameras; ++i) {
        if (const std::uint64_t word = seen_[i].load(std::memory_order_relaxed); word != watch.words[i]) {
            watch.words[i] = word;
            watch.changed[i] = watch.images;
        }
        if (watch.words[i] == 0 || watch.images - watch.changed[i] > kMissed) {
            continue;
        }
        const Brightness one = unpacked(watch.words[i]);
        sight.rig.median += one.median;
        sight.rig.bright = std::max(sight.rig.bright, one.bright);
        sight.rig.saturated = std::max(sight.rig.saturated, one.saturated);
        sight.first = std::min(sight.first, i);
        ++sight.cameras;
    }
    sight.rig.median /= sight.cameras;  // the one that looks lives
    return sight;
}

void SharedExposure::expect(Watch& watch, const ExposureSetting& setting) {
    if (setting != watch.setting) {
        watch.setting = setting;
        // Two more than the latency: the other camera may be one behind.
        watch.exposed_so = watch.images + static_cast<std::uint32_t>(options_.latency_frames) + 2;
    }
}

void SharedExposure::add_image(std::size_t camera, const ImageView& image) {
    Watch& watch = watches_[camera];
    ++watch.images;
    seen_[camera].store(packed(measure_brightness(image), watch.images), std::memory_order_relaxed);
    const Sight sight = look_around(watch);
    expect(watch, setting());
    if (sight.first != camera || static_cast<std::int32_t>(watch.images - watch.exposed_so) < 0) {
        return;
    }
    const ExposureSetting next = next_setting(options_, watch.setting, sight.rig);
    if (next != watch.setting) {
        setting_.store(packed(next), std::memory_order_relaxed);
        expect(watch, next);
    }
}

void ExposureHistory::add(std::uint32_t sequence, Duration exposure) {
    if (count_ == changes_.size()) {
        std::move(changes_.begin() + 1, changes_.end(), changes_.begin());
        --count_;
    }
    changes_[count_++] = {sequence, exposure};
}

Duration ExposureHistory::at(std::uint32_t sequence, Duration fallback) const {
    for (std::size_t i = count_; i-- > 0;) {
        if (static_cast<std::int32_t>(sequence - changes_[i].sequence) >= 0) {
            return changes_[i].exposure;
        }
    }
    return count_ > 0 ? changes_[0].exposure : fallback;
}

}  // namespace facet
