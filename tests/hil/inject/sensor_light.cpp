// SPDX-License-Identifier: BSD-2-Clause
#include "tests/hil/inject/sensor_light.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace facet::hil {

void SensorLight::at_edge(std::size_t camera, const std::optional<ExposureControls>& set) {
    now_[camera] = next_[camera];
    next_[camera] = set.value_or(next_[camera]);
}

std::span<const std::uint8_t> SensorLight::image(std::size_t camera, std::span<const std::uint8_t> recorded,
                                                 Duration since_start, double dimming) {
    const double phase = 2.0 * std::numbers::pi * since_start.seconds() / options_.period_s;
    const double light = std::pow(options_.swing, std::sin(phase)) * dimming;
    const double scale = light * now_[camera].exposure * now_[camera].gain / ExposureControls::kUsual;
    std::array<std::uint8_t, 256> table{};
    for (std::size_t grey = 0; grey < table.size(); ++grey) {
        table[grey] = static_cast<std::uint8_t>(std::min(std::lround(scale * static_cast<double>(grey)), 255L));
    }
    std::array<std::size_t, 256> counts{};
    shown_.resize(recorded.size());
    for (std::size_t i = 0; i < recorded.size(); ++i) {
        shown_[i] = table[recorded[i]];
        ++counts[shown_[i]];
    }
    grey_[camera] = {};
    std::size_t below = 0;
    for (std::size_t grey = 0; grey < counts.size(); ++grey) {
        grey_[camera].median += below * 2 < shown_.size() ? 1 : 0;
        grey_[camera].bright += below * 100 < shown_.size() * 98 ? 1 : 0;
        below += counts[grey];
    }
    return shown_;
}

}  // namespace facet::hil
