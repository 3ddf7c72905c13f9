// SPDX-License-Identifier: BSD-2-Clause
// Where synchronised stereo pairs come from.
#pragma once

#include "platform/base/samples.h"
#include "platform/port/source.h"

namespace facet {

/// A source of pairs that are synchronised already: a recorded log, a simulator, a stereo camera with one clock.
class StereoSource : public Source {
public:
    /// Next pair; see Source. Its views stay valid until the next call.
    virtual Status next(Duration timeout, StereoFrame& frame) = 0;
};

}  // namespace facet
