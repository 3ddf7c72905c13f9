// SPDX-License-Identifier: BSD-2-Clause
// What exposure, gain and the light in the room make of a log's images.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "platform/base/timestamp.h"

namespace facet::hil {

/// Light goes up and down by a factor of `swing` either way, as a sine of its logarithm.
struct LightOptions {
    double swing = 1.0;
    double period_s = 60.0;
};

/// What has been set in one camera.
struct ExposureControls {
    std::int32_t exposure = kUsual;  ///< steps of 0.1 ms
    std::int32_t gain = 1;

    static constexpr std::int32_t kUsual = 40;  ///< with gain 1 and light 1 an image is that of the log
    bool operator==(const ExposureControls&) const = default;
};

/// How bright an image is.
struct ShownGrey {
    int median = -1;  ///< half of the pixels are as dark, or darker
    int bright = -1;  ///< 98 % are
};

/// A sensor takes what is set between the edges of frames k and k + 1 for frame k + 2. Thread-bound.
class SensorLight {
public:
    explicit SensorLight(const LightOptions& options) : options_(options) {}

    /// At the edge of a frame. @param set  nullopt: the camera is not there, and keeps what it has
    void at_edge(std::size_t camera, const std::optional<ExposureControls>& set);
    /// Of the frame whose edge was last, and of the next one.
    Duration exposure(std::size_t camera) const { return time_of(now_[camera]); }
    Duration next_exposure(std::size_t camera) const { return time_of(next_[camera]); }

    /// What the camera shows of an image of the log, valid until the next call.
    /// @param since_start  of the flight; @param dimming  of the light besides its swing
    std::span<const std::uint8_t> image(std::size_t camera, std::span<const std::uint8_t> recorded,
                                        Duration since_start, double dimming);
    /// Of the image that was shown last.
    const ShownGrey& grey(std::size_t camera) const { return grey_[camera]; }

private:
    static Duration time_of(const ExposureControls& controls) { return Duration{controls.exposure * 100'000}; }

    LightOptions options_;
    std::array<ExposureControls, 2> now_;
    std::array<ExposureControls, 2> next_;
    std::array<ShownGrey, 2> grey_{};
    std::vector<std::uint8_t> shown_;
};

}  // namespace facet::hil
