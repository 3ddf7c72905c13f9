// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/mesh_accuracy.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <random>
#include <span>
#include <utility>

#include "app/support/statistics.h"
#include "platform/base/angle.h"

namespace facet {
namespace {

constexpr double kIcpGate = 0.3;  // m: farther samples do not pull
constexpr int kIcpIterations = 50;
constexpr double kIcpStep = 1e-4;    // rad and m: what moves less has converged
constexpr double kIcpFloor = 0.002;  // m: a perfect mesh has no scatter
constexpr double kTukey = 4.685;     // 95 % efficiency on normal errors
constexpr std::size_t kIcpSamples = 20000;
constexpr double kBoxMargin = 0.05;    // m: and this near to its box
constexpr double kPlaneMargin = 0.02;  // m: true surface this near to a true plane is part of it,
constexpr double kPlaneTurnDeg = 2.0;  // if turned like it

TriangleSoup transformed(const TriangleSoup& soup, const Se3& T) {
    TriangleSoup out = soup;
    for (Eigen::Vector3d& v : out.vertices) {
        v = T * v;
    }
    return out;
}

using Matches = std::vector<TriangleTree::Nearest>;

Matches match(const TriangleTree& tree, const std::vector<Eigen::Vector3d>& points, double limit) {
    Matches matches;
    matches.reserve(points.size());
    for (const Eigen::Vector3d& p : points) {
        matches.push_back(tree.nearest(p, limit));
    }
    return matches;
}

DistanceStatistics statistics_of(const Matches& matches) {
    std::vector<double> distances;
    distances.reserve(matches.size());
    for (const TriangleTree::Nearest& nearest : matches) {
        distances.push_back(nearest.distance);
    }
    return distance_statistics(std::move(distances));
}

/// What the samples of a mesh in the true world are nearest to.
Matches match_samples(const TriangleSoup& aligned, const TriangleTree& truth_tree, const MeshEvalOptions& options) {
    return match(truth_tree, sample_surface(aligned, options.samples_per_m2), options.max_distance_m);
}

/// @param matches  match_samples() of the aligned mesh
MeshRow measure(const std::string& name, const TriangleSoup& aligned, const Matches& matches,
                const std::vector<Eigen::Vector3d>& seen, const Se3& T_true_est, const MeshEvalOptions& options) {
    const TriangleTree tree(aligned);
    MeshRow row;
    row.alignment = name;
    row.T_true_est = T_true_est;
    row.accuracy = statistics_of(matches);
    row.completeness = statistics_of(match(tree, seen, options.max_distance_m));
    return row;
}

/// A sample of the mesh and the true plane it is compared with.
struct PlanePull {
    Eigen::Matrix<double, 6, 1> j;  ///< of r with respect to a left perturbation in the true world, [theta t]
    double r = 0.0;                 ///< n . (p - q) (m)
};

/// Pulls of all samples within the gate.
std::vector<PlanePull> pulls_of(const std::vector<Eigen::Vector3d>& samples, std::size_t step, const Se3& T,
                                const TriangleSoup& surface, const TriangleTree& truth_tree) {
    std::vector<PlanePull> pulls;
    for (std::size_t i = 0; i < samples.size(); i += step) {
        const Eigen::Vector3d p = T * samples[i];
        const TriangleTree::Nearest nearest = truth_tree.nearest(p, kIcpGate);
        if (nearest.triangle >= 0) {
            const Eigen::Vector3d n = surface.normal(static_cast<std::size_t>(nearest.triangle));
            PlanePull pull;
            pull.j << p.cross(n), n;
            pull.r = n.dot(p - nearest.point);
            pulls.push_back(pull);
        }
    }
    return pulls;
}

/// Standard deviation of the distances without their tails: 1.4826 times the median magnitude, at least kIcpFloor.
double robust_sigma(const std::vector<PlanePull>& pulls) {
    std::vector<double> magnitudes;
    magnitudes.reserve(pulls.size());
    for (const PlanePull& pull : pulls) {
        magnitudes.push_back(std::abs(pull.r));
    }
    return std::max(1.4826 * OrderStatistics(std::move(magnitudes)).median(), kIcpFloor);
}

struct Registration {
    Se3 T;
    bool is_converged = false;
};

/// Gauss-Newton on the distances to the planes of the nearest true triangles [Chen91], with Tukey's weights: wrong
/// faces, which lie between surfaces and mostly on one side of them, do not pull beyond 4.685 sigma. It has converged
/// when a step is below kIcpStep; otherwise the result is of no use.
Registration register_to_surface(const TriangleSoup& mesh, const TriangleSoup& surface, const TriangleTree& truth_tree,
                                 const Se3& start) {
    const std::vector<Eigen::Vector3d> samples = sample_surface(mesh, 200.0);
    const std::size_t step = samples.size() / kIcpSamples + 1;
    Registration result{start};
    for (int iteration = 0; iteration < kIcpIterations && !result.is_converged; ++iteration) {
        const std::vector<PlanePull> pulls = pulls_of(samples, step, result.T, surface, truth_tree);
        const double width = kTukey * robust_sigma(pulls);
        Eigen::Matrix<double, 6, 6> h = 1e-9 * Eigen::Matrix<double, 6, 6>::Identity();
        Eigen::Matrix<double, 6, 1> g = Eigen::Matrix<double, 6, 1>::Zero();
        for (const PlanePull& pull : pulls) {
            const double inner = std::max(0.0, 1.0 - (pull.r / width) * (pull.r / width));
            const double weight = inner * inner;
            h += weight * pull.j * pull.j.transpose();
            g += weight * pull.r * pull.j;
        }
        const Eigen::Matrix<double, 6, 1> d = -h.ldlt().solve(g);
        const Eigen::Quaterniond dq = so3_exp(d.head<3>());
        result.T = Se3{(dq * result.T.q).normalized(), dq * result.T.p + d.tail<3>()};
        result.is_converged = d.norm() < kIcpStep;
    }
    return result;
}

/// @param samples  of the true surface
double covered_area(const TriangleSoup& aligned, const std::vector<Eigen::Vector3d>& samples,
                    const MeshEvalOptions& options) {
    const TriangleTree tree(aligned);
    const auto covered = std::count_if(samples.begin(), samples.end(), [&](const Eigen::Vector3d& p) {
        return tree.nearest(p, options.overlap_distance_m).triangle >= 0;
    });
    return static_cast<double>(covered) / options.truth_samples_per_m2;
}

/// Splits the accuracy by what the nearest true surface is.
void measure_flat(const Matches& matches, const SceneTruth& truth, const MeshEvalOptions& options,
                  MeshEvaluation& result) {
    std::vector<EvalPlane> large;
    for (const EvalPlane& plane : truth.planes) {
        if (plane.seen_m2 >= options.flat_seen_m2 && is_level_or_upright(plane.normal)) {
            large.push_back(plane);
        }
    }
    std::vector<double> flat;
    std::vector<double> uneven;
    for (const TriangleTree::Nearest& nearest : matches) {
        const bool is_flat =
            nearest.triangle >= 0 &&
            plane_at(large, nearest.point, truth.surface.normal(static_cast<std::size_t>(nearest.triangle))) >= 0;
        (is_flat ? flat : uneven).push_back(nearest.distance);
    }
    result.flat = distance_statistics(std::move(flat));
    result.uneven = distance_statistics(std::move(uneven));
}

}  // namespace

int plane_at(const std::vector<EvalPlane>& planes, const Eigen::Vector3d& p, const Eigen::Vector3d& n) {
    const double least_cosine = std::cos(kPlaneTurnDeg * kRadPerDeg);
    int best = -1;
    double nearest = kPlaneMargin;
    for (std::size_t k = 0; k < planes.size(); ++k) {
        const double off = std::abs(planes[k].normal.dot(p) - planes[k].distance);
        if (off < nearest && n.dot(planes[k].normal) > least_cosine &&
            planes[k].box.squaredExteriorDistance(p) < kBoxMargin * kBoxMargin) {
            nearest = off;
            best = static_cast<int>(k);
        }
    }
    return best;
}

bool is_level_or_upright(const Eigen::Vector3d& n, double max_tilt_deg) {
    const double limit = std::sin(max_tilt_deg * kRadPerDeg);
    return n.head<2>().norm() < limit || std::abs(n.z()) < limit;
}

DistanceStatistics distance_statistics(std::vector<double> distances) {
    DistanceStatistics s;
    const OrderStatistics order(std::move(distances));
    s.count = order.count();
    if (s.count == 0) {
        return s;
    }
    const auto n = static_cast<double>(s.count);
    const std::span<const double> sorted = order.sorted();
    for (const double d : sorted) {
        s.mean += d / n;
        s.rmse += d * d / n;
    }
    s.rmse = std::sqrt(s.rmse);
    s.median = order.upper_median();
    s.p90 = order.quantile(0.9);
    for (std::size_t i = 0; i < kMeshTolerances.size(); ++i) {
        const auto end = std::upper_bound(sorted.begin(), sorted.end(), kMeshTolerances[i]);
        s.within[i] = static_cast<double>(end - sorted.begin()) / n;
    }
    return s;
}

std::vector<Eigen::Vector3d> sample_surface(const TriangleSoup& soup, double per_m2, std::vector<int>* triangle_of) {
    std::vector<Eigen::Vector3d> samples;
    std::mt19937_64 random(1);
    const auto uniform = [&random] { return static_cast<double>(random() >> 11U) * 0x1p-53; };
    double due = 0.5;  // samples not yet placed: areas add up across triangles
    for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
        for (due += soup.area(i) * per_m2; due >= 1.0; due -= 1.0) {
            const double r = std::sqrt(uniform());
            const double s = uniform();
            samples.push_back((1.0 - r) * soup.corner(i, 0) + r * (1.0 - s) * soup.corner(i, 1) +
                              r * s * soup.corner(i, 2));
            if (triangle_of != nullptr) {
                triangle_of->push_back(static_cast<int>(i));
            }
        }
    }
    return samples;
}

bool was_seen(const SceneTruth& truth, const TriangleTree& truth_tree, const Eigen::Vector3d& p, double depth_m) {
    constexpr double kMargin = 0.01;  // m: the surface itself is not in its own way
    return std::any_of(truth.T_W_C0.begin(), truth.T_W_C0.end(), [&](const Se3& T_W_C0) {
        if ((p - T_W_C0.p).squaredNorm() > depth_m * depth_m) {
            return false;
        }
        Eigen::Vector2d uv;
        return ok(truth.camera.project(T_W_C0.q.conjugate() * (p - T_W_C0.p), uv)) && truth.camera.in_image(uv, 0.0) &&
               !truth_tree.blocks(T_W_C0.p, p, kMargin);
    });
}

MeshEvaluation evaluate_mesh(const TriangleSoup& mesh, const SceneTruth& truth, const Se3& T_true_est,
                             const MeshEvalOptions& options) {
    MeshEvaluation result;
    result.faces = mesh.triangles.size();
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        result.area_m2 += mesh.area(i);
        for (int k = 0; k < 3; ++k) {
            result.longest_side_m =
                std::max(result.longest_side_m, (mesh.corner(i, k) - mesh.corner(i, (k + 1) % 3)).norm());
        }
    }
    const TriangleTree truth_tree(truth.surface);
    const std::vector<Eigen::Vector3d> all = sample_surface(truth.surface, options.truth_samples_per_m2);
    std::vector<Eigen::Vector3d> seen;
    std::copy_if(all.begin(), all.end(), std::back_inserter(seen),
                 [&](const Eigen::Vector3d& p) { return was_seen(truth, truth_tree, p, options.seen_depth_m); });
    result.seen_area_m2 = static_cast<double>(seen.size()) / options.truth_samples_per_m2;
    const TriangleSoup aligned = transformed(mesh, T_true_est);
    result.covered_m2 = covered_area(aligned, all, options);
    const Matches matches = match_samples(aligned, truth_tree, options);
    result.by_trajectory = measure("trajectory, SE(3)", aligned, matches, seen, T_true_est, options);
    result.holes = find_flat_holes(aligned, truth, truth_tree, options);
    measure_flat(matches, truth, options, result);
    const Registration icp = register_to_surface(mesh, truth.surface, truth_tree, T_true_est);
    const TriangleSoup registered = transformed(mesh, icp.T);
    result.by_icp =
        measure("ICP on the surface", registered, match_samples(registered, truth_tree, options), seen, icp.T, options);
    result.icp_converged = icp.is_converged;
    return result;
}

}  // namespace facet
