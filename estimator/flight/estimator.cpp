// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/api/estimator.h"

#include "estimator/flight/flight.h"

namespace facet {

Estimator::Estimator() : flight_(std::make_unique<FlightEstimator>()) {}
Estimator::~Estimator() = default;

Status Estimator::configure(const EstimatorConfig& config, const StereoRig& rig) {
    return flight_->configure(config, rig);
}

Status Estimator::set_masks(const ImageView& left, const ImageView& right) { return flight_->set_masks(left, right); }

void Estimator::set_stage_observer(StageObserver* observer) { flight_->set_stage_observer(observer); }

void Estimator::set_observation_hook(ObservationHook* hook) { flight_->set_observation_hook(hook); }

void Estimator::request_reset() { flight_->request_reset(); }

void Estimator::report_overrun() { flight_->report_overrun(); }

void Estimator::set_planes(const PlaneProposals& planes) { flight_->set_planes(planes); }

Status Estimator::add_imu(const ImuSample& sample, ImuAxisMask clipped) { return flight_->add_imu(sample, clipped); }

Status Estimator::add_imu(const ImuSample& sample) {
    return flight_->add_imu(sample, flight_->config().imu_limits.clipped_axes(sample));
}

Status Estimator::add_range(const RangeSample& sample) { return flight_->add_range(sample); }

Status Estimator::take_carried(Estimate& estimate) { return flight_->take_carried(estimate); }

Status Estimator::add_frame(const StereoFrame& frame, Estimate& estimate) {
    return flight_->add_frame(frame, estimate);
}

void Estimator::finish_frame() { flight_->finish_frame(); }

bool Estimator::keyframe_waits() const { return flight_->waits_at_newest_frame(); }

const KeyframeView& Estimator::keyframe_view() const { return flight_->keyframe_view(); }

const VisionResiduals& Estimator::residuals() const { return flight_->residuals(); }

const Belief& Estimator::belief() const { return flight_->belief(); }

KeptState Estimator::keep() const { return flight_->keep(); }

Status Estimator::resume(const KeptState& kept, double elapsed_s) { return flight_->resume(kept, elapsed_s); }

CalibrationEstimate Estimator::calibration() const { return flight_->calibration(); }

std::span<const MemoryPart> Estimator::memory() { return FlightEstimator::memory(); }

}  // namespace facet
