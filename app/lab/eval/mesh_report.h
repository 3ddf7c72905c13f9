// SPDX-License-Identifier: BSD-2-Clause
// Presents the evaluation of a mesh and of planes as text and as JSON.
#pragma once

#include <string>

#include "app/lab/eval/mesh_accuracy.h"
#include "app/lab/eval/plane_accuracy.h"

namespace facet {

/// Table for people; names the alignment of each row.
std::string text_report(const MeshEvaluation& evaluation);
std::string text_report(const PlaneEvaluation& evaluation);

/// One JSON object as text, metres.
std::string json_report(const MeshEvaluation& evaluation, const std::string& mesh, const std::string& scene);
std::string json_report(const PlaneEvaluation& evaluation, const std::string& planes);

}  // namespace facet
