// SPDX-License-Identifier: BSD-2-Clause
// What the window knows of the calibration, from one of its beginnings to the next.
#include <cmath>

#include "estimator/window/calibration_prior.h"
#include "estimator/window/window.h"

namespace facet {

CalibrationMatrix Window::begin_calibration(CalibrationStart start) {
    constexpr double kBelievable = 4.0;  // standard deviations of what was given
    const int dim = calibration_config_.dim();
    const CalibrationMatrix nothing = CalibrationMatrix::Zero(dim, dim);
    const bool is_forgotten = start == CalibrationStart::kAsGiven || calibration_stretch() > kBelievable;
    CalibrationMatrix information;
    keeps_given_ = is_forgotten || !known_information(information);
    is_resumed_ = false;
    if (is_forgotten) {
        state_.calibration = {};
        quality_.forget();
    }
    state_.given = keeps_given_ ? scaled_given() : nothing;
    return keeps_given_ ? nothing : information;
}

bool Window::known_information(CalibrationMatrix& information) {
    const int dim = calibration_config_.dim();
    if (is_factorized_) {
        return invert_covariance(workspace_.solver.leading_covariance(dim), information);
    }
    if (is_resumed_) {
        information = CalibrationMatrix::Zero(dim, dim);
        information.diagonal() = resumed_information_.head(dim);
    }
    return is_resumed_;
}

Status Window::resume_calibration(const RigCalibration& correction, const RigCalibration::Tangent& sigma) {
    constexpr double kInflation = 2.0;
    const int dim = calibration_config_.dim();
    const RigCalibration::Tangent value = RigCalibration{}.box_minus_to(correction);
    const auto used = sigma.head(dim).array();
    if (!value.allFinite() || !used.allFinite() || !(used > 0.0).all()) {
        return Status::kInvalidArgument;
    }
    RigCalibration::Tangent estimated = RigCalibration::Tangent::Zero();
    estimated.head(dim) = value.head(dim);
    state_.calibration = RigCalibration{}.box_plus(estimated);
    resumed_information_.setZero();
    resumed_information_.head(dim) = (kInflation * used).square().inverse();
    is_resumed_ = true;
    return Status::kOk;
}

void Window::forget_calibration() {
    state_.calibration = {};
    quality_.forget();
    is_factorized_ = is_resumed_ = false;
}

CalibrationMatrix Window::scaled_given() const {
    // How the pair is mounted is a camera's pose, unless it is known roughly only, which says nothing of the cameras.
    return quality_.scaled(given_information_, calibration_config_.estimate_extrinsics ? kRigDim : kRigTheta);
}

void Window::learn_calibration_quality() {
    if (!calibration_config_.estimate_cameras || !keeps_given_ || !is_factorized_) {
        return;
    }
    const RigCalibration::Tangent correction = RigCalibration{}.box_minus_to(state_.calibration);
    quality_.learn(correction.segment<kCameraTermsDim>(kRigDim), cameras_covariance());
    state_.given = scaled_given();
}

void Window::let_calibration_wander(Timestamp stamp) {
    constexpr double kPeriod_s = 1.0;  // short against what it takes to wander noticeably
    const double elapsed_s = (stamp - wandered_).seconds();
    if (elapsed_s < kPeriod_s) {
        return;
    }
    wandered_ = stamp;
    for (int i = 0; i < calibration_config_.dim(); ++i) {
        state_.prior.add_walk(i, std::pow(calibration_config_.walk_per_sqrt_s(i), 2) * elapsed_s);
    }
}

}  // namespace facet
