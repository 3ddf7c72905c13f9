// SPDX-License-Identifier: BSD-2-Clause
// Verdicts on the calibration of a log, from a few seconds of its images and all of its inertial samples.
#pragma once

#include <string>
#include <vector>

#include "app/calibration/calibration.h"
#include "app/lab/check/verdict.h"

namespace facet {

class LogFiles;

struct CheckOptions {
    std::string dataset;  ///< EuRoC/ASL folder
    Calibration calibration;
    LogFiles* files = nullptr;  ///< where its files are, if not on the disk; borrowed
    double images_s = 12.0;  ///< length of the stretch whose images are read: the one in which the vehicle turns most
};

/// Reads the log and applies all checks: imu_checks.h, stereo_check.h and turn_check.h. No estimator is involved, so
/// that a calibration with which it fails is judged all the same. Takes seconds. Throws InputError if the log cannot be
/// read. Heap. Thread-bound.
std::vector<CheckVerdict> check_calibration(const CheckOptions& options);

/// Whether any verdict is "wrong".
bool has_wrong(const std::vector<CheckVerdict>& verdicts);

/// Writes the verdicts with their figures as JSON. Throws InputError if the file cannot be written.
void write_verdicts(const std::vector<CheckVerdict>& verdicts, const std::string& path);

}  // namespace facet
