// SPDX-License-Identifier: BSD-2-Clause
// Accuracy and completeness of a mesh against the true surface.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "app/lab/eval/plane_file.h"
#include "app/lab/eval/trajectory.h"
#include "app/lab/eval/triangle_tree.h"
#include "estimator/geometry/camera_model.h"

namespace facet {

/// Tolerances of the shares and of F1 (m).
inline constexpr std::array<double, 6> kMeshTolerances{0.01, 0.02, 0.05, 0.10, 0.20, 0.50};

struct MeshEvalOptions {
    double samples_per_m2 = 1000.0;       ///< on the mesh, as in [Rosinol19]
    double truth_samples_per_m2 = 250.0;  ///< on the true surface: each one is tested for being seen
    double max_distance_m = 2.0;          ///< distances are capped here
    double overlap_distance_m = 0.10;     ///< true surface this near to the mesh is covered by it
    double seen_depth_m = 5.0;            ///< the true surface counts as seen from nearer than this
    double pose_interval_s = 0.2;         ///< of the views that decide what was seen
    double wall_distance_m = 0.10;        ///< a face within this of a true plane, and turned like it, covers it
    double wall_angle_deg = 20.0;
    double wall_cell_m = 0.02;  ///< raster of the search for holes
    double wall_gap_m = 0.10;   ///< a hole that opens to the outside through a gap narrower than this is still a hole
    double flat_seen_m2 = 1.0;  ///< a floor or wall of which less was seen does not count as one
};

/// Distances of a set of samples in figures; median and p90 as OrderStatistics::upper_median() and quantile().
struct DistanceStatistics {
    std::size_t count = 0;
    double median = 0.0;
    double mean = 0.0;
    double rmse = 0.0;
    double p90 = 0.0;
    std::array<double, kMeshTolerances.size()> within{};  ///< share within each tolerance
};
DistanceStatistics distance_statistics(std::vector<double> distances);

/// The mesh after one alignment.
struct MeshRow {
    std::string alignment;
    Se3 T_true_est;
    DistanceStatistics accuracy;      ///< mesh samples to the true surface
    DistanceStatistics completeness;  ///< seen true samples to the mesh
    double f1(std::size_t tolerance) const {
        const double a = accuracy.within[tolerance];
        const double c = completeness.within[tolerance];
        return a + c > 0.0 ? 2.0 * a * c / (a + c) : 0.0;
    }
};

/// Holes of the mesh on the true planes: cells that it does not cover and that a square of wall_gap_m cannot reach from
/// outside without touching covered ones, where there is a surface that was seen. Planes that coincide count once.
struct FlatHoles {
    double covered_m2 = 0.0;
    double hole_m2 = 0.0;
    int planes = 0;  ///< with at least half a square metre covered
    double share() const { return covered_m2 + hole_m2 > 0.0 ? hole_m2 / (covered_m2 + hole_m2) : 0.0; }
};

struct MeshEvaluation {
    std::size_t faces = 0;
    double area_m2 = 0.0;
    double longest_side_m = 0.0;
    double seen_area_m2 = 0.0;  ///< of the true surface
    double covered_m2 = 0.0;    ///< of the true surface, seen or not, within overlap_distance_m of the mesh
    /// Layers of mesh that lie on each other: its area over what it covers.
    double overlap() const { return covered_m2 > 0.0 ? area_m2 / covered_m2 : 0.0; }
    MeshRow by_trajectory;
    MeshRow by_icp;              ///< starts from the other; wrong faces do not pull
    bool icp_converged = false;  ///< otherwise by_icp means nothing
    // Aligned by trajectory:
    FlatHoles holes;
    DistanceStatistics flat;    ///< accuracy where the nearest true surface is a large floor or wall
    DistanceStatistics uneven;  ///< accuracy elsewhere
};

/// The true scene and who looked at it.
struct SceneTruth {
    TriangleSoup surface;
    std::vector<EvalPlane> planes;  ///< may be empty
    CameraModel camera;             ///< left
    std::vector<Se3> T_W_C0;        ///< where it was, in the true world
};

/// Index of the true plane that a point p of the true surface with normal n belongs to; -1: none.
int plane_at(const std::vector<EvalPlane>& planes, const Eigen::Vector3d& p, const Eigen::Vector3d& n);

/// A true plane turned farther from level and upright is neither floor nor wall.
inline constexpr double kFlatTiltDeg = 3.0;

/// Whether a plane of this normal is a floor or a wall.
bool is_level_or_upright(const Eigen::Vector3d& n, double max_tilt_deg = kFlatTiltDeg);

/// Evenly spread points of a surface: every triangle gets its area's share; the places within a triangle are
/// pseudo-random with a fixed seed.
/// @param triangle_of  triangle of each sample, appended; nullptr to skip
std::vector<Eigen::Vector3d> sample_surface(const TriangleSoup& soup, double per_m2,
                                            std::vector<int>* triangle_of = nullptr);

/// Evaluates a mesh given in the world of the estimate. Heap. Reentrant.
MeshEvaluation evaluate_mesh(const TriangleSoup& mesh, const SceneTruth& truth, const Se3& T_true_est,
                             const MeshEvalOptions& options);

/// Holes of a mesh that is in the true world.
FlatHoles find_flat_holes(const TriangleSoup& mesh, const SceneTruth& truth, const TriangleTree& truth_tree,
                          const MeshEvalOptions& options);

/// Whether some view saw the point from nearer than `depth_m` with nothing in between.
bool was_seen(const SceneTruth& truth, const TriangleTree& truth_tree, const Eigen::Vector3d& p, double depth_m);

}  // namespace facet
