// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/calibrate/batch_inertial.h"

#include <memory>
#include <utility>

#include "estimator/imu/imu_buffer.h"

namespace facet {

Status integrate_chain(const RecordedFlight& flight, const ImuNoise& noise, const ImuLimits& limits,
                       const GravityConfig& gravity, InertialChain& out) {
    InertialChain chain;
    const auto buffer = std::make_unique<ImuBuffer>(noise.rate_hz, limits);
    std::size_t next = 0;
    for (std::size_t k = 0; k < flight.keyframes.size(); ++k) {
        const RecordedKeyframe& keyframe = flight.keyframes[k];
        while (next < flight.imu.size() && (buffer->empty() || buffer->newest() < keyframe.stamp)) {
            FACET_TRY(buffer->push(flight.imu[next++]));
        }
        ImuSample sample;
        FACET_TRY(buffer->interpolate(keyframe.stamp, sample));
        chain.w_B.push_back(sample.w_B - keyframe.state.bias.gyro);
        if (k > 0) {
            const RecordedKeyframe& previous = flight.keyframes[k - 1];
            Preintegration preintegration(previous.state.bias, gravity.magnitude_m_per_s2);
            FACET_TRY(buffer->integrate_between(previous.stamp, keyframe.stamp, noise, preintegration));
            FACET_TRY(chain.factors.emplace_back().set(preintegration, noise));
        }
    }
    out = std::move(chain);
    return Status::kOk;
}

}  // namespace facet
