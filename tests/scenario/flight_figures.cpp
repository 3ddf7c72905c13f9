// SPDX-License-Identifier: BSD-2-Clause
#include "tests/scenario/flight_figures.h"

#include <catch2/catch.hpp>
#include <vector>

#include "app/calibration/calibration.h"
#include "app/lab/eval/scene_truth.h"
#include "app/lab/eval/trajectory.h"
#include "app/lab/eval/uncertain_states.h"
#include "drivers/replay_asl/ground_truth.h"

namespace facet::test {
namespace {

std::vector<GroundTruthState> true_states(const std::string& log) {
    std::vector<GroundTruthState> states;
    std::string error;
    REQUIRE(ok(read_ground_truth(log + "/mav0/state_groundtruth_estimate0/data.csv", {}, states, error)));
    return states;
}

Trajectory poses_of(const std::vector<GroundTruthState>& states) {
    Trajectory poses;
    for (const GroundTruthState& s : states) {
        poses.push_back({s.stamp, {s.q_W_B, s.p_W_B}});
    }
    return poses;
}

}  // namespace

Evaluation evaluate_trajectory(const std::string& log, const std::string& out) {
    return evaluate(poses_of(true_states(log)), read_tum(out + "/trajectory.tum"), {}, {});
}

FlightFigures evaluate_flight(const std::string& log, const std::string& out) {
    const std::vector<GroundTruthState> states = true_states(log);
    const Trajectory truth = poses_of(states);
    const Trajectory estimate = read_tum(out + "/trajectory.tum");
    FlightFigures figures;
    figures.trajectory = evaluate(truth, estimate, {}, {});
    figures.claims =
        evaluate_consistency(states, read_uncertain_states(out + "/trajectory.csv", out + "/covariance.csv"));

    const Calibration calibration = load_euroc_calibration(log + "/mav0");
    const SceneTruth scene =
        load_scene(log + "/truth/scene.ply", calibration.rig.left, calibration.rig.T_B_C0,
                   associate(truth, estimate, EvaluationOptions{}.max_truth_gap), MeshEvalOptions{}.pose_interval_s);
    const Se3& T_true_est = figures.trajectory.se3.T_true_est;
    figures.mesh = evaluate_mesh(load_mesh(out + "/mesh.ply"), scene, T_true_est, {});
    figures.planes =
        evaluate_planes(read_planes(out + "/planes.csv"), load_surfaces(out + "/planes.json"), scene, T_true_est, {});
    return figures;
}

}  // namespace facet::test
