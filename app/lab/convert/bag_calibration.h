// SPDX-License-Identifier: BSD-2-Clause
// The calibration that a bag brings along: CameraInfo and /tf_static.
#pragma once

#include <optional>
#include <string>

#include "app/calibration/calibration.h"
#include "app/lab/convert/bag_survey.h"
#include "app/lab/convert/topic_choice.h"

namespace facet {

/// Lenses from the CameraInfo beside the topics of images (K and D; P of rectified ones, which are recognised by their
/// names), places from the way through /tf_static from the IMU's frame to the cameras'. The IMU's noise is assumed, at
/// the rate of its samples. @param lack  what is missing, if anything is
/// Throws InputError if a lens is there and implausible.
std::optional<Calibration> calibration_of_bag(const BagSurvey& survey, const ChosenTopics& topics, std::string& lack);

}  // namespace facet
