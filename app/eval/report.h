// SPDX-License-Identifier: BSD-2-Clause
// Presents an evaluation as a text table and as JSON.
#pragma once

#include <string>

#include "app/eval/evaluation.h"

namespace facet {

/// Table for people; always names the alignment modes.
std::string text_report(const Evaluation& evaluation);

/// One JSON object. Errors in metres and degrees; statistics without data are null.
std::string json_report(const Evaluation& evaluation, const std::string& groundtruth, const std::string& estimate);

}  // namespace facet
