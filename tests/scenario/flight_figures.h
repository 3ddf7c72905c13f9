// SPDX-License-Identifier: BSD-2-Clause
// Accuracy of a replayed simulated flight: trajectory, claimed covariance, mesh and planes against the truth.
#pragma once

#include <string>

#include "app/lab/eval/consistency.h"
#include "app/lab/eval/evaluation.h"
#include "app/lab/eval/mesh_accuracy.h"
#include "app/lab/eval/plane_accuracy.h"

namespace facet::test {

struct FlightFigures {
    Evaluation trajectory;
    Consistency claims;
    MeshEvaluation mesh;
    PlaneEvaluation planes;
};

/// The trajectory alone. @param log  folder of the simulator  @param out  folder of the replay
Evaluation evaluate_trajectory(const std::string& log, const std::string& out);

/// Everything, aligned as `facet eval` does it.
FlightFigures evaluate_flight(const std::string& log, const std::string& out);

}  // namespace facet::test
