// SPDX-License-Identifier: BSD-2-Clause
// Whether every second frame is lit by an infrared emitter, whose dots move with the vehicle.
#pragma once

#include <algorithm>
#include <cmath>

namespace facet {

/// Depth cameras can switch their emitter from frame to frame (RealSense: alternating emitter): every second image then
/// has dots that are fixed to the vehicle, and thousands of corners that the next image lacks. They are recognised by
/// their contrast (relative_contrast()), which alternates far more than motion, noise or a lamp's flicker makes it. A
/// gain or an exposure that alternates leaves it alone. Thread-bound. No heap.
class EmitterWatch {
public:
    /// At each frame of the camera that is tracked in.
    /// @param contrast  of the image; 0 if it has none @return the frame shows the dots, and is to be left out
    bool step(double contrast);
    /// Frames are being left out.
    bool is_alternating() const { return is_alternating_; }

private:
    /// Between images that follow each other the logarithm of the contrast changes by 0.02 in flight, 0.1 at most
    /// (four sequences, real ones too); by 0.4 to 0.8 where dots come and go over a textured room.
    static constexpr double kLeastSwing = 0.15;
    static constexpr int kRecognised = 8;
    static constexpr int kMost = 16;  ///< eight frames that do not alternate end it
    static constexpr double kForget = 0.9;

    double last_ = 0.0;   ///< contrast
    double swing_ = 0.0;  ///< size of the last one that counted
    int alternations_ = 0;
    bool is_lit_ = false;
    bool is_alternating_ = false;
};

inline bool EmitterWatch::step(double contrast) {
    const double change = std::min(contrast, last_) > 0.0 ? std::log(contrast / last_) : 0.0;
    last_ = contrast;
    // A frame that was lost on the way leaves two alike in a row.
    const bool swings = std::abs(change) > std::max(kLeastSwing, swing_ / 2.0);
    const bool alternates = swings && (change > 0.0) != is_lit_;
    if (swings) {
        is_lit_ = change > 0.0;
    }
    swing_ = alternates ? std::abs(change) : swing_ * kForget;
    alternations_ = std::clamp(alternations_ + (alternates ? 1 : -2), 0, kMost);
    is_alternating_ = is_alternating_ ? alternations_ > 0 : alternations_ >= kRecognised;
    return is_alternating_ && is_lit_;
}

}  // namespace facet
