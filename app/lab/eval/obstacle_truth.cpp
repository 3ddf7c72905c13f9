// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/obstacle_truth.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/lab/eval/mesh_accuracy.h"
#include "app/support/input_error.h"

namespace facet {
namespace {

/// A cube about the origin.
TriangleSoup make_cube(double side_m) {
    TriangleSoup cube;
    for (int i = 0; i < 8; ++i) {
        cube.vertices.push_back(0.5 * side_m *
                                Eigen::Vector3d((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1));
    }
    for (int axis = 0; axis < 3; ++axis) {
        const int u = 1 << ((axis + 1) % 3);
        const int v = 1 << ((axis + 2) % 3);
        for (const int from : {0, 1 << axis}) {
            cube.triangles.emplace_back(from, from + u, from + u + v);
            cube.triangles.emplace_back(from, from + u + v, from + v);
        }
    }
    return cube;
}

Eigen::Vector3d vector_of(const nlohmann::json& json) {
    return {json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>()};
}

}  // namespace

std::optional<MoverTruth> MoverTruth::load(const std::string& path) {
    std::ifstream file(path);
    if (!file) {
        return std::nullopt;
    }
    try {
        const nlohmann::json json = nlohmann::json::parse(file);
        const Timestamp epoch{json.at("epoch_ns").get<std::int64_t>()};
        std::vector<Crossing> crossings;
        for (const nlohmann::json& c : json.at("crossings")) {
            crossings.push_back({epoch + Duration::from_seconds(c.at("begin_s").get<double>()),
                                 epoch + Duration::from_seconds(c.at("end_s").get<double>()),
                                 vector_of(c.at("start_m")), vector_of(c.at("velocity_m_per_s")),
                                 c.at("start_yaw_rad").get<double>(), c.at("yaw_rate_rad_per_s").get<double>()});
        }
        return MoverTruth(json.at("side_m").get<double>(), std::move(crossings));
    } catch (const nlohmann::json::exception& e) {
        throw InputError(path + ": no path of a mover: " + e.what());
    }
}

std::optional<Se3> MoverTruth::pose(Timestamp stamp) const {
    for (const Crossing& c : crossings_) {
        if (stamp >= c.begin && stamp <= c.end) {
            const double dt = (stamp - c.begin).seconds();
            const double yaw = c.start_yaw_rad + dt * c.yaw_rate_rad_per_s;
            return Se3{Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ())), c.start_W + dt * c.v_W};
        }
    }
    return std::nullopt;
}

ObstacleTruth::ObstacleTruth(const TriangleSoup& scene, std::optional<MoverTruth> mover)
    : tree_(scene),
      scene_samples_(sample_surface(scene, kSamples_per_m2)),
      mover_(std::move(mover)),
      box_(mover_ ? make_cube(mover_->side_m()) : TriangleSoup{}),
      box_tree_(box_),
      box_samples_(sample_surface(box_, kSamples_per_m2)) {}

double ObstacleTruth::cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double limit_m,
                           Timestamp stamp) const {
    const double scene_m = tree_.cast(origin, direction, limit_m);
    const std::optional<Se3> T_W_M = mover_ ? mover_->pose(stamp) : std::nullopt;
    return T_W_M ? box_tree_.cast(T_W_M->inverse() * origin, T_W_M->q.conjugate() * direction, scene_m) : scene_m;
}

double ObstacleTruth::distance(const Eigen::Vector3d& p, double limit_m, Timestamp stamp) const {
    const double scene_m = tree_.nearest(p, limit_m).distance;
    const std::optional<Se3> T_W_M = mover_ ? mover_->pose(stamp) : std::nullopt;
    return T_W_M ? box_tree_.nearest(T_W_M->inverse() * p, scene_m).distance : scene_m;
}

std::vector<Eigen::Vector3d> ObstacleTruth::samples(Timestamp stamp) const {
    std::vector<Eigen::Vector3d> samples = scene_samples_;
    if (const std::optional<Se3> T_W_M = mover_ ? mover_->pose(stamp) : std::nullopt) {
        for (const Eigen::Vector3d& p : box_samples_) {
            samples.push_back(*T_W_M * p);
        }
    }
    return samples;
}

std::optional<Se3> alignment_at(const std::vector<PosePair>& pairs, Timestamp stamp) {
    constexpr Duration kSame{1'000'000};  // stamps of other files may be rounded
    const auto pair = std::lower_bound(pairs.begin(), pairs.end(), stamp + Duration{-kSame.ns},
                                       [](const PosePair& p, Timestamp s) { return p.stamp < s; });
    if (pair == pairs.end() || pair->stamp > stamp + kSame) {
        return std::nullopt;
    }
    return pair->truth * pair->estimate.inverse();
}

}  // namespace facet
