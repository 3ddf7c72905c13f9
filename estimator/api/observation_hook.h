// SPDX-License-Identifier: BSD-2-Clause
// A look at what the front-end saw, before the smoother does.
#pragma once

#include <span>

#include "estimator/values/observation.h"
#include "platform/base/timestamp.h"

namespace facet {

/// May change the observations of a frame between front-end and smoother. For studies, which put the truth in the place of
/// a stage to see what that stage costs; the front-end itself goes on from what it saw.
class ObservationHook {
public:
    virtual ~ObservationHook() = default;
    /// @param stamp  of the frame, as given
    virtual void edit(Timestamp stamp, std::span<FeatureObservation> observations) = 0;
};

}  // namespace facet
