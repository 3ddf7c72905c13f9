// SPDX-License-Identifier: BSD-2-Clause
#include "app/commands/eval_command.h"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>

#include "app/calibration/calibration.h"
#include "app/commands/run_guarded.h"
#include "app/lab/eval/consistency.h"
#include "app/lab/eval/details.h"
#include "app/lab/eval/evaluation.h"
#include "app/lab/eval/mesh_report.h"
#include "app/lab/eval/obstacle_accuracy.h"
#include "app/lab/eval/report.h"
#include "app/lab/eval/scene_truth.h"
#include "app/lab/eval/sweep_accuracy.h"
#include "app/support/console.h"
#include "app/support/input_error.h"
#include "app/support/progress.h"
#include "app/support/text_file.h"
#include "drivers/replay_asl/asl_dataset.h"
#include "drivers/replay_asl/ground_truth.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

/// Shares of the work that are done, in percent, about; and for how long nothing is said of it.
constexpr std::size_t kSceneLoaded = 20;
constexpr std::size_t kMeshCompared = 90;
constexpr double kPatience_s = 2.0;

struct EvalArguments {
    std::string groundtruth;
    std::string estimate;
    std::string json;
    std::string errors;
    std::string details;
    std::string scene;
    std::string mesh;
    std::vector<double> rpe_lengths_m{1.0, 2.0, 5.0, 10.0};
};

void print_warning(const AslWarning& warning) { print_err("warning: {}\n", warning.text()); }

/// Whether a file of poses is TUM's: by its name, or by its first row, whose numbers no comma parts.
bool is_tum_file(const std::string& path) {
    std::error_code ignored;
    if (path.ends_with(".tum") || !fs::is_regular_file(path, ignored)) {
        return path.ends_with(".tum");
    }
    std::ifstream file(path);
    for (std::string row; std::getline(file, row);) {
        const std::size_t first = row.find_first_not_of(" \t\r");
        if (first != std::string::npos && row[first] != '#') {
            return row.find(',') == std::string::npos;
        }
    }
    return false;
}

std::vector<GroundTruthState> load_true_states(const std::string& path) {
    const std::string table = find_ground_truth(path);
    if (table.empty()) {
        throw InputError(path + ": no state_groundtruth_estimate0/data.csv in it");
    }
    std::vector<GroundTruthState> states;
    std::string error;
    if (!ok(read_ground_truth(table, print_warning, states, error))) {
        throw InputError(error);
    }
    return states;
}

/// A file of poses, which tells nothing of motion.
std::vector<GroundTruthState> states_of(const Trajectory& poses) {
    std::vector<GroundTruthState> states;
    for (const StampedPose& pose : poses) {
        states.push_back({.stamp = pose.stamp, .p_W_B = pose.T_W_B.p, .q_W_B = pose.T_W_B.q});
    }
    return states;
}

Trajectory poses_of(const std::vector<GroundTruthState>& states) {
    Trajectory truth;
    for (const GroundTruthState& s : states) {
        truth.push_back({s.stamp, {s.q_W_B, s.p_W_B}});
    }
    return truth;
}

/// Stamps of the left camera, empty if the dataset has none: they only refine the coverage.
std::vector<Timestamp> load_frame_stamps(const std::string& path) {
    std::vector<Timestamp> stamps;
    const std::string root = AslDataset::find_root(path);
    CsvFile csv;
    if (root.empty() || !csv.open(root + "/cam0/data.csv")) {
        return stamps;
    }
    std::vector<std::string_view> fields;
    Timestamp stamp;
    while (csv.next(fields)) {
        if (parse_stamp(fields.front(), stamp.ns)) {
            stamps.push_back(stamp);
        }
    }
    std::sort(stamps.begin(), stamps.end());
    stamps.erase(std::unique(stamps.begin(), stamps.end()), stamps.end());
    return stamps;
}

/// The estimator's claims against the truth; nothing if the folder has no covariance.csv.
std::optional<Claims> check_claims(const EvalArguments& args, const std::vector<GroundTruthState>& truth,
                                   const TruthFit& fit) {
    std::error_code ignored;
    const std::string covariance = args.estimate + "/covariance.csv";
    if (!fs::is_regular_file(covariance, ignored)) {
        if (!args.errors.empty()) {
            throw InputError("--errors: needs an --estimate folder with covariance.csv");
        }
        return std::nullopt;
    }
    const std::vector<UncertainState> states = read_uncertain_states(args.estimate + "/trajectory.csv", covariance);
    Claims claims{evaluate_consistency(truth, states), std::nullopt};
    if (fit.is_known) {
        claims.with_fit = evaluate_consistency(with_fit(truth, fit), states);
    }
    if (!args.errors.empty()) {
        write_errors(claims.as_is, args.errors);
    }
    if (!args.details.empty()) {
        write_errors(claims.as_is, args.details + "/errors.csv");
    }
    return claims;
}

/// The trajectory's part of --details.
void write_trajectory_details(const EvalArguments& args, const Trajectory& truth, const Trajectory& estimate,
                              const Evaluation& evaluation) {
    if (args.details.empty() || evaluation.matched == 0) {
        return;
    }
    const std::vector<PosePair> pairs = associate(truth, estimate, EvaluationOptions{}.max_truth_gap);
    write_absolute_errors(pairs, evaluation.se3.T_true_est, args.details + "/ate.csv");
    write_relative_errors(pairs, args.rpe_lengths_m, args.details + "/rpe.csv");
}

SceneTruth load_true_scene(const EvalArguments& args, const Trajectory& truth, const Trajectory& estimate) {
    const std::string root = AslDataset::find_root(args.groundtruth);
    if (root.empty()) {
        throw InputError("--scene: --groundtruth must be a dataset folder, for its camera");
    }
    const Calibration calibration = load_euroc_calibration(root);
    return load_scene(args.scene, calibration.rig.left, calibration.rig.T_B_C0,
                      associate(truth, estimate, EvaluationOptions{}.max_truth_gap), MeshEvalOptions{}.pose_interval_s);
}

/// The object `member` (JSON text) as last member `name` of the object `json`.
std::string with_member(const std::string& json, const std::string& name, const std::string& member) {
    return json.substr(0, json.rfind('}')) + ",\n\"" + name + "\": " + member + "\n}\n";
}

/// Prints how mesh and planes compare with the scene, and adds it to `json`. Planes are compared if the folder of the
/// estimate has planes.csv and the scene a list of its planes.
std::string evaluate_scene(const EvalArguments& args, const SceneTruth& scene, const Se3& T_true_est,
                           std::string json) {
    const std::string mesh = !args.mesh.empty() ? args.mesh : args.estimate + "/mesh.ply";
    const TriangleSoup triangles = load_mesh(mesh);
    const MeshEvaluation mesh_evaluation = evaluate_mesh(triangles, scene, T_true_est, {});
    if (!args.details.empty()) {
        write_mesh_distances(triangles, scene.surface, T_true_est, MeshEvalOptions{}.max_distance_m,
                             args.details + "/mesh_distance.csv");
    }
    print_out("{}", text_report(mesh_evaluation));
    json = with_member(json, "mesh", json_report(mesh_evaluation, mesh, args.scene));
    std::error_code ignored;
    const std::string planes = args.estimate + "/planes.csv";
    if (!scene.planes.empty() && fs::is_regular_file(planes, ignored)) {
        const std::optional<PlaneSurfaces> surfaces = load_surfaces(args.estimate + "/planes.json");
        const PlaneEvaluation plane_evaluation = evaluate_planes(read_planes(planes), surfaces, scene, T_true_est, {});
        print_out("{}", text_report(plane_evaluation));
        json = with_member(json, "planes", json_report(plane_evaluation, planes));
    }
    return json;
}

/// Prints how the live grid compares with the scene, and adds it to `json`, if the folder of the estimate has rays.csv
/// and sweeps.csv. A box that moves through the scene is known from mover.json beside it.
std::string evaluate_grid(const EvalArguments& args, const Trajectory& truth, const Trajectory& estimate,
                          const SceneTruth& scene, std::string json) {
    std::error_code ignored;
    const std::string rays = args.estimate + "/rays.csv";
    const std::string sweeps = args.estimate + "/sweeps.csv";
    if (!fs::is_regular_file(rays, ignored)) {
        return json;
    }
    const ObstacleTruth world(scene.surface,
                              MoverTruth::load((fs::path(args.scene).parent_path() / "mover.json").string()));
    const std::vector<PosePair> pairs = associate(truth, estimate, EvaluationOptions{}.max_truth_gap);
    const ObstacleEvaluation by_rays = evaluate_obstacles(read_rays(rays), pairs, world, {});
    print_out("{}", text_report(by_rays));
    json = with_member(json, "obstacles", json_report(by_rays));
    if (fs::is_regular_file(sweeps, ignored)) {
        const SweepEvaluation by_sectors = evaluate_sweeps(read_sweeps(sweeps), pairs, world, {});
        print_out("{}", text_report(by_sectors));
        json = with_member(json, "sweeps", json_report(by_sectors));
    }
    return json;
}

int evaluate_files(const EvalArguments& args) {
    for (const double length : args.rpe_lengths_m) {
        if (!(length > 0.0)) {
            throw InputError(fmt::format("--rpe-lengths: {} is not a positive length", length));
        }
    }
    if (!args.details.empty()) {
        make_folder(args.details);
    }
    std::error_code ignored;
    const bool is_folder = fs::is_directory(args.estimate, ignored);
    std::string tum = is_folder ? args.estimate + "/trajectory.tum" : args.estimate;
    if (is_folder && !fs::exists(tum, ignored) && fs::exists(tum + TextFile::kPartEnding, ignored)) {
        tum += TextFile::kPartEnding;  // of a flight that was cut off
    }
    const Trajectory estimate = read_tum(tum);
    const bool is_tum = is_tum_file(args.groundtruth);
    const std::vector<GroundTruthState> states =
        is_tum ? states_of(read_tum(args.groundtruth)) : load_true_states(args.groundtruth);
    const Trajectory truth = poses_of(states);
    EvaluationOptions options;
    options.rpe_lengths_m = args.rpe_lengths_m;
    const Evaluation evaluation = evaluate(truth, estimate, load_frame_stamps(args.groundtruth), options);
    write_trajectory_details(args, truth, estimate, evaluation);
    const std::optional<Claims> claims = check_claims(args, states, evaluation.truth_fit);
    print_out("{}{}", text_report(evaluation), claims ? text_report(*claims) : "");
    std::string json = json_report(evaluation, args.groundtruth, tum, claims ? &*claims : nullptr);
    if (!args.scene.empty() && evaluation.matched > 0) {
        Progress progress("eval", "", 100, kPatience_s);
        const SceneTruth scene = load_true_scene(args, truth, estimate);
        progress.update(kSceneLoaded);
        json = evaluate_scene(args, scene, evaluation.se3.T_true_est, json);
        progress.update(kMeshCompared);
        json = evaluate_grid(args, truth, estimate, scene, json);
        progress.update(100);
        progress.finish();
    }
    if (!args.json.empty()) {
        TextFile file(args.json);
        file.write(json);
        file.close();
    }
    return evaluation.matched == 0 ? kExitFailed : kExitDone;
}

}  // namespace

void add_eval_command(CLI::App& app, int& exit_code) {
    CLI::App* command = app.add_subcommand("eval", "Compare an estimated trajectory with the ground truth");
    auto args = std::make_shared<EvalArguments>();
    command
        ->add_option(
            "--groundtruth", args->groundtruth,
            "Dataset with state_groundtruth_estimate0/data.csv, or such a .csv, or a file in TUM format (.tum, .txt)")
        ->type_name("PATH")
        ->required();
    command->add_option("--estimate", args->estimate, "Folder with trajectory.tum, or a file in TUM format")
        ->type_name("DIR")
        ->required();
    command->add_option("--json", args->json, "Also write the figures to this file")->type_name("FILE");
    command
        ->add_option("--errors", args->errors,
                     "Also write error, reported sigma and NEES of each sample with a covariance to this file (CSV)")
        ->type_name("FILE");
    command
        ->add_option("--details", args->details,
                     "Also write the series behind the figures into this folder, for scripts/report: ate.csv, "
                     "rpe.csv, errors.csv as --errors does, and with --scene mesh_distance.csv")
        ->type_name("DIR");
    command
        ->add_option("--scene", args->scene,
                     "True surface (PLY; planes.json beside it is used for holes and planes): also evaluates the "
                     "mesh, and planes.csv, rays.csv and sweeps.csv in the folder of --estimate")
        ->type_name("FILE");
    command->add_option("--mesh", args->mesh, "Mesh to evaluate; mesh.ply in the folder of --estimate by default")
        ->type_name("FILE");
    command->add_option("--rpe-lengths", args->rpe_lengths_m, "Path lengths of the relative errors (m)")
        ->type_name("METRES")
        ->delimiter(',')
        ->capture_default_str();
    command->footer(
        "ATE: absolute trajectory error after alignment by SE(3) and by 4 DoF (yaw + translation), never with scale.\n"
        "RPE: relative pose error over stretches of the true path.\n"
        "NEES: if the folder has covariance.csv, squared errors over the reported covariance, after yaw and position "
        "are aligned where the position is known best; a consistent estimator's mean is the number of components.\n"
        "Mesh: distances of 1000 samples/m^2 to the true surface (accuracy), and of the true surface seen from within "
        "5 m to the mesh (completeness), aligned by the trajectory and by ICP.\n"
        "Planes: share of the found planes that match a true one (precision), and of the true level or upright planes "
        "that were found (recall), if 1 m^2 was in view from within 5 m for 2 s. Strictly: within 2 degrees and 3 cm, "
        "with true surface in half of the plane's regions; duplicates are wrong, planes taken back from planes.json "
        "do not count; true planes of 0.5 m^2 seen count for recall.\n"
        "Obstacles: the live grid within 5 m, tolerance 20 cm: missed is reported free beyond the true surface, false "
        "is an obstacle before it, phantom is one with no true surface near.\n"
        "Exit codes: 0 done; 1 no estimate matches the ground truth; 2 bad usage or input.");
    command->callback([args, &exit_code] { exit_code = run_guarded([&] { return evaluate_files(*args); }); });
}

}  // namespace facet
