// SPDX-License-Identifier: BSD-2-Clause
// A hook to change the front-end's observations before the smoother receives them.
#pragma once

#include <span>

#include "estimator/values/observation.h"
#include "platform/base/timestamp.h"

namespace facet {

/// May change the observations of a frame between front-end and smoother. For studies that replace the output of a
/// stage by the truth to see what that stage costs; the front-end itself continues from what it saw.
class ObservationHook {
public:
    virtual ~ObservationHook() = default;
    /// @param stamp  of the frame, as given
    virtual void edit(Timestamp stamp, std::span<FeatureObservation> observations) = 0;
};

}  // namespace facet
