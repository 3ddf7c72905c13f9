// SPDX-License-Identifier: BSD-2-Clause
// Whether the vehicle stands, by inertial samples and images.
#pragma once

#include "estimator/imu/stationarity.h"

namespace facet {

/// At rest at every frame since the newest keyframe. Thread-bound. No heap.
class RestDetector {
public:
    /// At a keyframe: as far as is known, the vehicle has not moved since.
    void begin() { rests_ = true; }
    void end() { rests_ = false; }

    /// @param images_rest  the images show no motion since the newest keyframe
    void step(bool images_rest, const ImuBuffer& imu, Timestamp stamp, const RestingImu& reference) {
        Stationarity stationarity;
        const Status known = measure_stationarity(imu, stamp, reference, stationarity);
        rests_ = rests_ && images_rest && ok(known) && stationarity.may_be_at_rest;
    }

    bool rests() const { return rests_; }

private:
    bool rests_ = false;
};

}  // namespace facet
