// SPDX-License-Identifier: BSD-2-Clause
// Presents an evaluation as a text table and as JSON.
#pragma once

#include <string>

#include "app/lab/eval/consistency.h"
#include "app/lab/eval/evaluation.h"

namespace facet {

/// Table for people; always names the alignment modes.
std::string text_report(const Evaluation& evaluation);

/// Table of NEES for people; names the gauge.
std::string text_report(const Consistency& consistency);

/// One JSON object. Errors in metres and degrees; statistics without data are null.
/// @param consistency  becomes the member "consistency"; left out if nullptr
std::string json_report(const Evaluation& evaluation, const std::string& groundtruth, const std::string& estimate,
                        const Consistency* consistency = nullptr);

}  // namespace facet
