// SPDX-License-Identifier: BSD-2-Clause
// Presents an evaluation as a text table and as JSON.
#pragma once

#include <string>

#include "app/lab/eval/consistency.h"
#include "app/lab/eval/evaluation.h"

namespace facet {

/// Table for people; always names the alignment modes.
std::string text_report(const Evaluation& evaluation);

/// Tables of NEES for people; they name the gauge.
std::string text_report(const Claims& claims);

/// One JSON object. Errors in metres and degrees; statistics without data are null.
/// @param claims  becomes the members "consistency" and, with the fitted truth, "consistency_with_fit"; left out if
///                nullptr
std::string json_report(const Evaluation& evaluation, const std::string& groundtruth, const std::string& estimate,
                        const Claims* claims = nullptr);

}  // namespace facet
