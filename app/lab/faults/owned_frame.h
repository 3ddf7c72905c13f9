// SPDX-License-Identifier: BSD-2-Clause
// A frame on its way from the log to the estimator.
#pragma once

#include "drivers/replay_asl/png_decoder.h"
#include "platform/base/samples.h"

namespace facet {

/// A frame with pixels of its own.
struct OwnedFrame {
    Timestamp stamp;         ///< that the estimator is given
    Timestamp log_stamp;     ///< what the log said
    Timestamp output_stamp;  ///< under which the estimate is filed: `stamp` with the jumps of clocks taken out again
    GreyImage left;
    GreyImage right;
    bool has_left = true;
    bool has_right = false;

    StereoFrame view() const {
        return {.stamp = stamp,
                .left = has_left ? left.view() : ImageView{},
                .right = has_right ? right.view() : ImageView{}};
    }
};

}  // namespace facet
