// SPDX-License-Identifier: BSD-2-Clause
// Whether images may contradict the inertial readings.
#pragma once

namespace facet {

/// A pair of images that match each other shows a motion in metres without the IMU. One camera does not: the scale of
/// its map is the inertial samples' own, and two images that do not match may both be wrong. The keyframe that the map
/// is of must have matched as well. Thread-bound. No heap.
class StereoEvidence {
public:
    /// At each frame. @param matches  of a keyframe between left and right @param few  so many do not tell
    void step(bool is_keyframe, int matches, int few) {
        const bool was_unmatched = is_unmatched_;
        if (is_keyframe) {
            is_unmatched_ = matches < few;
        }
        is_independent_ = !was_unmatched && !is_unmatched_;
    }
    /// After step(). @param is_suspected  inertial readings are suspected @param is_keyframe  one that may judge them
    void support(bool is_suspected, bool is_keyframe) {
        has_supported_ = is_suspected && (has_supported_ || (is_keyframe && is_independent_));
    }

    /// The newest frame may contradict the inertial readings.
    bool is_independent() const { return is_independent_; }
    /// The newest keyframe's images do not match each other, or there is one.
    bool is_unmatched() const { return is_unmatched_; }
    /// The present suspicion has had the support of a keyframe.
    bool has_supported() const { return has_supported_; }

private:
    bool is_unmatched_ = false;
    bool is_independent_ = true;
    bool has_supported_ = false;
};

}  // namespace facet
