// SPDX-License-Identifier: BSD-2-Clause
// Where images of one camera come from.
#pragma once

#include <cstdint>

#include "platform/base/image_view.h"
#include "platform/base/slot_lease.h"
#include "platform/port/source.h"

namespace facet {

/// One image as a camera gives it, not paired yet. A side-by-side stereo node gives one image of double width.
struct CameraFrame {
    Timestamp stamp;             ///< exposure midpoint, as well as the camera knows it, in the clock of the source
    std::uint32_t sequence = 0;  ///< the camera's own count; gaps are lost images
    ImageView image;             ///< 8-bit grey, in a slot of the source; valid while `slot` is held
    SlotLease slot;              ///< ends with the frame, on any thread
    Duration exposure;           ///< zero if unknown
};

/// A camera. When every slot is lent, newer images are dropped and counted as discarded. The camera must outlive the
/// frames it has given.
class CameraSource : public Source {
public:
    /// Next image; see Source.
    virtual Status next(Duration timeout, CameraFrame& frame) = 0;
};

}  // namespace facet
