// SPDX-License-Identifier: BSD-2-Clause
// Presents the evaluation of a mesh as text and as JSON.
#pragma once

#include <string>

#include "app/eval/mesh_accuracy.h"

namespace facet {

/// Table for people; names the alignment of each row.
std::string text_report(const MeshEvaluation& evaluation);

/// One JSON object as text, metres.
std::string json_report(const MeshEvaluation& evaluation, const std::string& mesh, const std::string& scene);

}  // namespace facet
