// SPDX-License-Identifier: BSD-2-Clause
// Exposure and gain by what the images look like, the same for all cameras of a rig.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <string>

#include "platform/base/image_view.h"
#include "platform/base/timestamp.h"

namespace facet {

struct AutoExposureOptions {
    std::string exposure_control = "exposure";
    std::string gain_control = "analogue_gain";
    double exposure_step_s = 1e-4;  ///< exposure time of one step of its control, such as a line's time
    int gain_one = 1;               ///< value of the gain's control at which the gain is 1; it is proportional
    int least_exposure = 1;         ///< steps
    int most_exposure = 100;        ///< steps: bounds motion blur
    int least_gain = 1;
    int most_gain = 1;
    double target = 90.0;    ///< grey value that the median of the pixels is brought to
    int latency_frames = 2;  ///< from setting the controls to the first frame exposed so
};

/// Values of the two controls.
struct ExposureSetting {
    std::int32_t exposure = 0;
    std::int32_t gain = 0;

    bool operator==(const ExposureSetting&) const = default;
};

/// How bright an image is: of a sixteenth of its pixels.
struct Brightness {
    double median = 0.0;
    double bright = 0.0;     ///< the value that 2 % of the pixels exceed
    double saturated = 0.0;  ///< share of pixels at 250 or above
};

/// No heap. Reentrant.
/// @param image  not empty
Brightness measure_brightness(const ImageView& image);

/// The setting after one at which the images of a rig look like that. The light taken in (exposure times gain) is
/// scaled by target / median, but not beyond where the brightest 2 % would saturate, by at most a factor of 2 at
/// once, and not at all within 8 % of the target. Exposure takes it as far as it may, then gain, which costs noise.
/// Reentrant.
ExposureSetting next_setting(const AutoExposureOptions& options, const ExposureSetting& now, const Brightness& seen);

/// What the cameras of a rig share. Each reports its images; the first camera that lives decides by the images of those
/// that live, and all follow. Thread-safe without locks, a thread for each camera: one that is late by an image sees
/// the decision before.
class SharedExposure {
public:
    static constexpr std::size_t kCameras = 2;
    /// A camera lives while another one shows no more images than this between two of its own: half a second at 20 Hz,
    /// after which its driver takes it for silent.
    static constexpr std::uint32_t kMissed = 10;

    /// Begins at the middle of the exposures, by ratio, and the least gain.
    explicit SharedExposure(AutoExposureOptions options);

    const AutoExposureOptions& options() const { return options_; }
    ExposureSetting setting() const;
    /// Every frame that a camera delivers, on its thread. A decision is taken when the images exposed by the last one
    /// are there.
    void add_image(std::size_t camera, const ImageView& image);

private:
    /// What one camera's thread knows.
    struct Watch {
        std::uint32_t images = 0;                       ///< its own
        std::array<std::uint64_t, kCameras> words{};    ///< the newest of each camera
        std::array<std::uint32_t, kCameras> changed{};  ///< `images` when they came
        ExposureSetting setting;                        ///< the newest
        std::uint32_t exposed_so = 0;                   ///< first of `images` exposed by it
    };
    struct Sight;

    Sight look_around(Watch& watch);
    void expect(Watch& watch, const ExposureSetting& setting);

    AutoExposureOptions options_;
    std::atomic<std::uint64_t> setting_;
    /// Count, saturated share, median and bright of each camera's newest image; 0: none yet.
    std::array<std::atomic<std::uint64_t>, kCameras> seen_{};
    std::array<Watch, kCameras> watches_;
};

/// Which exposure time a camera's frames had: the setting of some frames ago. Thread-bound. No heap.
class ExposureHistory {
public:
    /// @param sequence  the first frame exposed so
    void add(std::uint32_t sequence, Duration exposure);
    /// @return the exposure in force at that frame; `fallback` if nothing is known of it
    Duration at(std::uint32_t sequence, Duration fallback) const;
    void clear() { count_ = 0; }

private:
    struct Change {
        std::uint32_t sequence = 0;
        Duration exposure;
    };
    std::array<Change, 8> changes_;  ///< the newest ones, oldest first
    std::size_t count_ = 0;
};

}  // namespace facet
