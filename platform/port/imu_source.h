// SPDX-License-Identifier: BSD-2-Clause
// Where inertial samples come from.
#pragma once

#include <limits>

#include "platform/base/samples.h"
#include "platform/port/source.h"

namespace facet {

/// An inertial sensor. Samples are in SI units and in the body frame B (the driver applies scale and axis map).
class ImuSource : public Source {
public:
    /// Next sample; see Source.
    virtual Status next(Duration timeout, ImuSample& sample) = 0;
    /// Of the sample given last (deg C); NaN if the sensor does not tell.
    virtual double temperature_c() const { return std::numeric_limits<double>::quiet_NaN(); }
};

}  // namespace facet
