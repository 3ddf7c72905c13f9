// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/sim/mover.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/support/rng.h"

namespace facet::sim {
namespace {

using Eigen::Vector3d;

constexpr double kCrossing_s = 3.0;
constexpr double kPeriod_s = 6.0;
constexpr double kCandidateStep_s = 0.25;
constexpr double kCheckStep_s = 0.25;
constexpr double kAhead_m = 1.7;     // of the camera, where the crossing begins and ends
constexpr double kAside_m = 2.8;     // beside its axis there: beyond the border of the view
constexpr double kRadius_m = 0.54;   // of the box about its vertical axis
constexpr double kKeepAway_m = 1.0;  // of the box's centre from the vehicle
constexpr double kHalfView = 1.1;    // tangent, distortion included
constexpr double kFarthest_m = 2.4;  // half-way, so that the box is large then
constexpr double kYawRate_rad_per_s = 0.4;
constexpr double kBoxLight = 0.8;  // irradiance, as on the scenes' walls

Scene make_box(const SceneDetail& detail) {
    SceneBuilder b("mover");
    const MaterialId sides = b.material({Pattern::kBooks, 71, 0.75, 0.02F, 0.75F, 0.0F, 0.0F});
    const MaterialId top = b.material({Pattern::kPoster, 72, 0.0, 0.03F, 0.8F, 0.0F, 0.0F});
    b.box("mover", sides, top, Vector3d::Zero(), Vector3d::Constant(Mover::kSide_m), 0.0);
    b.ambient(kBoxLight);
    return b.build(detail);
}

/// How well a crossing works: the least of three clearances in metres, but at most kKeepAway_m: between the box and the
/// scene's surfaces while it is in view, between the vehicle and the box, and by how much the box is nearer than too
/// far half-way.
double spare_room(const Scene& scene, const Flight& flight, const Se3& T_B_C, const Crossing& c) {
    const double middle_s = 0.5 * (c.begin_s + c.end_s);
    const Se3 T_W_B = flight.evaluate(middle_s).T_W_B;
    double spare = std::min(kKeepAway_m, kFarthest_m - (c.start_W + 0.5 * kCrossing_s * c.v_W - T_W_B.p).norm());
    for (double t = c.begin_s; t <= c.end_s; t += kCheckStep_s) {
        const Se3 T_W_C = flight.evaluate(t).T_W_B * T_B_C;
        const Vector3d box_W = c.start_W + (t - c.begin_s) * c.v_W;
        const Vector3d to_box = box_W - T_W_C.p;
        spare = std::min(spare, to_box.norm() - kKeepAway_m);
        const Vector3d box_C = T_W_C.inverse() * box_W;
        if (box_C.z() > 0.0 && std::abs(box_C.x()) < kHalfView * box_C.z()) {
            const RayHit hit = scene.cast(T_W_C.p, to_box.normalized());
            spare = std::min(spare, hit.distance - to_box.norm() - kRadius_m);
        }
    }
    return spare;
}

Crossing crossing_at(const Flight& flight, const Se3& T_B_C, double begin_s, double side) {
    Crossing c;
    c.begin_s = begin_s;
    c.end_s = begin_s + kCrossing_s;
    const auto beside = [&](double t, double x) {
        return (flight.evaluate(t).T_W_B * T_B_C) * Vector3d(x, 0.0, kAhead_m);
    };
    c.start_W = beside(c.begin_s, -side * kAside_m);
    c.v_W = (beside(c.end_s, side * kAside_m) - c.start_W) / kCrossing_s;
    return c;
}

}  // namespace

Mover::Mover(const SceneDetail& detail, std::vector<Crossing> crossings)
    : box_(make_box(detail)), crossings_(std::move(crossings)) {}

std::optional<MoverPose> Mover::pose(double t_s) const {
    for (const Crossing& c : crossings_) {
        if (t_s >= c.begin_s && t_s <= c.end_s) {
            const double dt = t_s - c.begin_s;
            const Eigen::AngleAxisd turn(c.start_yaw_rad + dt * c.yaw_rate_rad_per_s, Vector3d::UnitZ());
            return MoverPose{turn.toRotationMatrix().cast<float>(), (c.start_W + dt * c.v_W).cast<float>(),
                             c.v_W.cast<float>(), static_cast<float>(c.yaw_rate_rad_per_s)};
        }
    }
    return std::nullopt;
}

void Mover::cover(const MoverPose& pose, const F4& taus, const RayPacket& packet, float spread, float* radiance) const {
    const Eigen::Matrix3f& r = pose.R_W_M;
    const F4 turn = pose.yaw_rate * taus;
    const auto into_box = [&](const V4& a) {  // Exp(-tau w e_z) R^T a
        const F4 x = r(0, 0) * a.x + r(1, 0) * a.y + r(2, 0) * a.z;
        const F4 y = r(0, 1) * a.x + r(1, 1) * a.y + r(2, 1) * a.z;
        return V4{x + turn * y, y - turn * x, r(0, 2) * a.x + r(1, 2) * a.y + r(2, 2) * a.z};
    };
    RayPacket rays;
    rays.origin = into_box({packet.origin.x - (pose.p_W.x() + taus * pose.v_W.x()),
                            packet.origin.y - (pose.p_W.y() + taus * pose.v_W.y()),
                            packet.origin.z - (pose.p_W.z() + taus * pose.v_W.z())});
    rays.direction = into_box(packet.direction);
    rays.t = packet.t;
    rays.primitive = I4{-1, -1, -1, -1};
    box_.bvh().intersect(rays);
    if (!any(rays.primitive >= 0)) {
        return;
    }
    float box[kLanes];
    box_.shade(rays, spread, box);
    for (int i = 0; i < kLanes; ++i) {
        radiance[i] = rays.primitive[i] >= 0 ? box[i] : radiance[i];
    }
}

std::vector<Crossing> plan_crossings(const Scene& scene, const Flight& flight, const Se3& T_B_C, double from_s,
                                     double end_s, std::uint64_t seed) {
    RandomStream random(seed, 41);
    std::vector<Crossing> crossings;
    Crossing roomiest;
    double most_room = -1e9;
    for (double period = from_s; period + kCrossing_s <= end_s; period += kPeriod_s) {
        const double yaw = random.uniform(-1.0, 1.0);
        Crossing best;
        double room = -1e9;
        const double latest = std::min(period + kPeriod_s, end_s) - kCrossing_s;
        for (double begin = period; begin <= latest; begin += kCandidateStep_s) {
            for (const double side : {-1.0, 1.0}) {
                const Crossing c = crossing_at(flight, T_B_C, begin, side);
                const double spare = spare_room(scene, flight, T_B_C, c);
                if (spare > room) {
                    room = spare;
                    best = c;
                }
            }
        }
        best.start_yaw_rad = yaw;
        best.yaw_rate_rad_per_s = yaw < 0.0 ? kYawRate_rad_per_s : -kYawRate_rad_per_s;
        if (room >= 0.0) {
            crossings.push_back(best);
        }
        if (room > most_room) {
            most_room = room;
            roomiest = best;
        }
    }
    if (crossings.empty() && most_room > -1e9) {
        crossings.push_back(roomiest);
    }
    return crossings;
}

std::string mover_json(const Mover& mover, Timestamp epoch) {
    const auto vector = [](const Vector3d& v) { return nlohmann::ordered_json::array({v.x(), v.y(), v.z()}); };
    nlohmann::ordered_json json;
    json["epoch_ns"] = epoch.ns;
    json["side_m"] = Mover::kSide_m;
    json["crossings"] = nlohmann::ordered_json::array();
    for (const Crossing& c : mover.crossings()) {
        json["crossings"].push_back({{"begin_s", c.begin_s},
                                     {"end_s", c.end_s},
                                     {"start_m", vector(c.start_W)},
                                     {"velocity_m_per_s", vector(c.v_W)},
                                     {"start_yaw_rad", c.start_yaw_rad},
                                     {"yaw_rate_rad_per_s", c.yaw_rate_rad_per_s}});
    }
    return json.dump(1) + "\n";
}

}  // namespace facet::sim
