// SPDX-License-Identifier: BSD-2-Clause
// Whether the window holds inertial factors that contradict it.
#pragma once

#include "estimator/values/nav_state.h"

namespace facet {

/// Contradictory readings bend a window, biases and tilt alike; once they are over it has to restart. While readings
/// are suspected, and thus replaced, nothing is judged. Thread-bound. No heap.
class FactorConsistency {
public:
    /// After a keyframe. @param contradicts  residuals of its inertial factor are too large
    /// @param bias_before  of the keyframe before it
    /// @return the window must restart: factors agree again
    bool step(bool contradicts, const ImuBias& bias_before) {
        if (contradicts) {
            bias_before_ = is_violated_ ? bias_before_ : bias_before;
            is_violated_ = true;
            agreeing_ = 0;
            return false;
        }
        return is_violated_ && ++agreeing_ == kAgreeing;
    }
    /// A window begins.
    void reset() {
        is_violated_ = false;
        agreeing_ = 0;
    }

    bool is_violated() const { return is_violated_; }
    /// What the biases were before.
    const ImuBias& bias_before() const { return bias_before_; }

private:
    static constexpr int kAgreeing = 2;  ///< keyframes

    bool is_violated_ = false;
    int agreeing_ = 0;  ///< keyframes since the last one that contradicted
    ImuBias bias_before_;
};

}  // namespace facet
