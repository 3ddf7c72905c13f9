// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/sim/flight.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <vector>

#include "app/support/rng.h"

namespace facet::sim {
namespace {

using Eigen::Vector3d;

constexpr double kStep_s = 0.35;  // knot spacing: sets how sharply the flight can turn
constexpr int kMaxDraws = 20;
constexpr double kYawShare = 0.8;  // of the rate limit; with twice kTiltShare the sum stays below the limit
constexpr double kTiltShare = 0.27;
constexpr double kInspectStep_s = 0.02;
constexpr double kClimb_m = 0.6;
constexpr double kClimbSpeed_m_per_s = 0.4;
constexpr double kHoverWander_m = 0.012;  // of each of three tones an axis: 1.5 cm rms, up to 5 cm
constexpr double kHoverYaw_rad = 0.01;    // likewise
constexpr double kGateShare = 0.6;        // of legs that go to a gate where one can be reached
constexpr double kGateReach_m = 9.0;
constexpr double kHoverNod = 0.15;  // of a tour's slow nods

constexpr double kFirstTurn_s = 3.5;  // after take-off: it has climbed
constexpr double kTurnPeriod_s = 5.0;
constexpr double kTurn_s = 3.0;    // of it spent turning
constexpr double kTurn_rad = 1.2;  // rate at most 1.5 kTurn_rad / kTurn_s

/// How far a flight that turns on the spot has turned at a time from its first turn's begin.
double turned_rad(double t_s) {
    if (t_s <= 0.0) {
        return 0.0;
    }
    const double before = std::floor(t_s / kTurnPeriod_s);
    const double part = std::min((t_s - before * kTurnPeriod_s) / kTurn_s, 1.0);
    return kTurn_rad * (before + part * part * (3.0 - 2.0 * part));
}

/// One random flight, leg by leg: straight legs between random free points at random speeds, camera turned to where
/// there is something to see; the spline rounds the corners.
class Pilot {
public:
    Pilot(const Scene& scene, const FlightPlan& plan, std::uint64_t seed)
        : scene_(scene), plan_(plan), random_(seed, 11) {}

    Flight fly() {
        const FlightVolume& volume = scene_.flight_volume();
        position_ = volume.start;
        yaw_ = volume.start_yaw_rad;
        yaw_target_ = yaw_;
        const int still = static_cast<int>(std::ceil(plan_.stand_s / kStep_s)) + 5;
        // A closed flight's points are mirrored at the last one: 2 n - 1 points are 2 n - 6 steps.
        const int count = plan_.closed ? static_cast<int>(std::floor(0.5 * plan_.duration_s / kStep_s)) + 3
                                       : static_cast<int>(std::ceil(plan_.duration_s / kStep_s)) + 6;
        for (int i = 0; i < still; ++i) {
            points_.push_back(position_);
            yaws_.push_back(yaw_);
        }
        if (plan_.kind != FlightKind::kTour) {
            hold_place(count);
            return Flight(Flight::Spline(kStep_s, mirrored(add_attitude(still, count, kHoverNod))));
        }
        int failures = 0;
        while (static_cast<int>(points_.size()) < count) {
            const Mark before{points_.size(), position_, yaw_, yaw_target_};
            fly_leg();
            if (leg_is_safe(before.size) || failures > 30) {
                failures = 0;
                continue;
            }
            points_.resize(before.size);
            yaws_.resize(before.size);
            position_ = before.position;
            yaw_ = before.yaw;
            yaw_target_ = before.yaw_target;
            if (++failures > 30) {
                hover();
            }
        }
        return Flight(Flight::Spline(kStep_s, mirrored(add_attitude(still, count, 1.0))));
    }

private:
    struct Mark {
        std::size_t size;
        Vector3d position;
        double yaw;
        double yaw_target;
    };

    void push(const Vector3d& p) {
        const double limit = kYawShare * plan_.max_rate_rad_per_s * kStep_s;
        const double wanted = yaw_target_ + 0.015 * random_.normal();
        yaw_ += std::clamp(wanted - yaw_, -limit, limit);
        position_ = p;
        const Vector3d wobble(random_.normal(), random_.normal(), random_.normal());
        points_.push_back(p + 0.015 * wobble);
        yaws_.push_back(yaw_);
    }

    /// Climbs as far as there is room, at most kClimb_m, and stays there: per axis a sum of three slow sinusoids.
    void hold_place(int count) {
        double climb = kClimb_m;
        while (climb > 0.0 && !(position_.z() + climb <= scene_.flight_volume().high.z() &&
                                scene_.clearance(position_ + Vector3d(0, 0, climb), 2.0) >
                                    scene_.flight_volume().clearance_m + 0.06)) {
            climb = std::max(0.0, climb - 0.1);
        }
        constexpr int kTones = 3;
        double rate[4][kTones];  // rad/s, of x y z and yaw
        double phase[4][kTones];
        for (int axis = 0; axis < 4; ++axis) {
            for (int k = 0; k < kTones; ++k) {
                rate[axis][k] = 2.0 * std::numbers::pi * random_.uniform(0.08 + 0.12 * k, 0.16 + 0.16 * k);
                phase[axis][k] = random_.uniform(0.0, 2.0 * std::numbers::pi);
            }
        }
        const int climb_steps = static_cast<int>(std::ceil(climb / (kClimbSpeed_m_per_s * kStep_s)));
        const Vector3d ground = position_;
        const double ground_yaw = yaw_;
        for (int i = 1; static_cast<int>(points_.size()) < count; ++i) {
            const double t = i * kStep_s;
            const double share = climb_steps == 0 ? 1.0 : std::min(1.0, static_cast<double>(i) / climb_steps);
            const auto wander = [&](int axis) {
                double sum = 0.0;
                for (int k = 0; k < kTones; ++k) {
                    sum += std::sin(rate[axis][k] * t + phase[axis][k]) - std::sin(phase[axis][k]);
                }
                return share * sum;
            };
            points_.push_back(ground + Vector3d(0, 0, share * climb) +
                              kHoverWander_m * Vector3d(wander(0), wander(1), wander(2)));
            const double turned = plan_.kind == FlightKind::kTurn ? turned_rad(t - kFirstTurn_s) : 0.0;
            yaws_.push_back(ground_yaw + turned + kHoverYaw_rad * wander(3));
        }
    }

    void hover() {
        look_around(position_);
        const int steps = 3;
        for (int i = 0; i < steps; ++i) {
            push(position_);
        }
    }

    /// Clearance and speed of the path that the points from `first` on have shaped.
    bool leg_is_safe(std::size_t first) const {
        const std::size_t from = first - std::min<std::size_t>(first, 6);
        const QuinticSpline<3> path(kStep_s, {points_.begin() + static_cast<std::ptrdiff_t>(from), points_.end()});
        for (double t = 0.0; t <= path.duration_s(); t += kInspectStep_s) {
            const auto s = path.evaluate(t);
            if (s.d1.norm() > plan_.max_speed_m_per_s ||
                scene_.clearance(s.x, 2.0) < scene_.flight_volume().clearance_m) {
                return false;
            }
        }
        return true;
    }

    void fly_leg() {
        Vector3d target = position_;
        if (random_.uniform() > 0.12 && pick_target(target)) {
            const double speed = random_.uniform(0.3, 0.93) * plan_.max_speed_m_per_s;
            const int steps =
                std::max(1, static_cast<int>(std::round((target - position_).norm() / (speed * kStep_s))));
            look_around(target);
            const Vector3d from = position_;
            for (int i = 1; i <= steps; ++i) {
                if (i == steps / 2 && random_.uniform() > 0.5) {
                    look_around(target);
                }
                push(from + (static_cast<double>(i) / steps) * (target - from));
            }
            return;
        }
        hover();
    }

    /// A point in the flight volume that can be reached in a straight line.
    bool pick_target(Vector3d& target) {
        const FlightVolume& volume = scene_.flight_volume();
        if (!volume.gates.empty() && random_.uniform() < kGateShare && pick_gate(target)) {
            return true;
        }
        for (int attempt = 0; attempt < 60; ++attempt) {
            Vector3d p;
            for (int i = 0; i < 3; ++i) {
                p[i] = random_.uniform(std::max(volume.low[i], position_[i] - volume.reach_m),
                                       std::min(volume.high[i], position_[i] + volume.reach_m));
            }
            const double length = (p - position_).norm();
            if (length < 1.0 || length > 4.5) {
                continue;
            }
            if (is_free(p)) {
                target = p;
                return true;
            }
        }
        return false;
    }

    /// The gate within reach that was passed least often.
    bool pick_gate(Vector3d& target) {
        const std::vector<Vector3d>& gates = scene_.flight_volume().gates;
        gate_passes_.resize(gates.size(), 0);
        std::size_t best = gates.size();
        for (std::size_t i = 0; i < gates.size(); ++i) {
            const double length = (gates[i] - position_).norm();
            if (length > 1.0 && length < kGateReach_m &&
                (best == gates.size() || gate_passes_[i] < gate_passes_[best]) && is_free(gates[i])) {
                best = i;
            }
        }
        if (best == gates.size()) {
            return false;
        }
        ++gate_passes_[best];
        target = gates[best];
        return true;
    }

    /// Whether the straight line to a place keeps its distance.
    bool is_free(const Vector3d& p) const {
        const int checks = static_cast<int>((p - position_).norm() / 0.1) + 1;
        bool free = true;
        for (int i = 1; i <= checks && free; ++i) {
            free = scene_.clearance(position_ + (static_cast<double>(i) / checks) * (p - position_), 2.0) >
                   scene_.flight_volume().clearance_m + 0.06;
        }
        return free;
    }

    /// Chooses, among random yaws, the one for which most of the view is 1.5 to 5 m away, both here and at the target.
    void look_around(const Vector3d& target) {
        double best = -1.0;
        double choice = yaw_target_;
        for (int k = 0; k < 7; ++k) {
            const double yaw = yaw_ + random_.uniform(-1.9, 1.9);
            double score = 0.3 * random_.uniform();
            for (const Vector3d& from : {position_, target}) {
                for (const double bearing : {-0.45, 0.0, 0.45}) {
                    const Vector3d d(std::cos(yaw + bearing), std::sin(yaw + bearing), -0.1);
                    const RayHit hit = scene_.cast(from, d.normalized());
                    score += std::min(hit.distance, 2.0) - 0.25 * std::max(0.0, hit.distance - 5.0) -
                             (hit.distance < 1.1 ? 2.0 : 0.0);
                }
            }
            if (k == 0 || score > best) {
                best = score;
                choice = yaw;
            }
        }
        yaw_target_ = choice;
    }

    /// Roll and pitch that partly follow the acceleration, as a multirotor's do, plus slow nods, `nod` times the usual.
    std::vector<Flight::Spline::Vector> add_attitude(int still, int count, double nod) {
        constexpr double kFollow = 0.5;
        constexpr double kMaxTilt = 0.25;
        constexpr double kNoseDown_rad = 0.15;
        std::vector<Flight::Spline::Vector> control;
        double roll_slow = 0.0;
        double pitch_slow = kNoseDown_rad;
        for (int i = 0; i < count; ++i) {
            Flight::Spline::Vector c;
            double roll = 0.0;
            double pitch = kNoseDown_rad;
            if (i >= still) {
                roll_slow = 0.93 * roll_slow + nod * 0.03 * random_.normal();
                pitch_slow = kNoseDown_rad + 0.93 * (pitch_slow - kNoseDown_rad) + nod * 0.035 * random_.normal();
                const Vector3d& next =
                    points_[static_cast<std::size_t>(std::min(i + 2, static_cast<int>(points_.size()) - 1))];
                const Vector3d a = (next - 2.0 * points_[i] + points_[i - 2]) / (4.0 * kStep_s * kStep_s);
                const double forward = std::cos(yaws_[i]) * a.x() + std::sin(yaws_[i]) * a.y();
                const double left = -std::sin(yaws_[i]) * a.x() + std::cos(yaws_[i]) * a.y();
                const double limit = kTiltShare * plan_.max_rate_rad_per_s * kStep_s;
                const double roll_wanted = std::clamp(roll_slow - kFollow * left / 9.81, -kMaxTilt, kMaxTilt);
                const double pitch_wanted = std::clamp(pitch_slow + kFollow * forward / 9.81, kNoseDown_rad - kMaxTilt,
                                                       kNoseDown_rad + kMaxTilt);
                roll = std::clamp(roll_wanted, control.back()[3] - limit, control.back()[3] + limit);
                pitch = std::clamp(pitch_wanted, control.back()[4] - limit, control.back()[4] + limit);
            }
            c << points_[i], roll, pitch, yaws_[i];
            control.push_back(c);
        }
        return control;
    }

    /// The way back behind the way out, if the flight is to be closed. A spline of mirrored points is mirrored.
    std::vector<Flight::Spline::Vector> mirrored(std::vector<Flight::Spline::Vector> control) const {
        if (plan_.closed) {
            const std::vector<Flight::Spline::Vector> out = control;
            control.insert(control.end(), std::next(out.rbegin()), out.rend());
        }
        return control;
    }

    const Scene& scene_;
    const FlightPlan& plan_;
    RandomStream random_;
    Vector3d position_ = Vector3d::Zero();
    double yaw_ = 0.0;
    double yaw_target_ = 0.0;
    std::vector<int> gate_passes_;
    std::vector<Vector3d> points_;
    std::vector<double> yaws_;
};

}  // namespace

FlightState Flight::evaluate(double t_s) const {
    const Spline::Value s = spline_.evaluate(t_s);
    const Eigen::Quaterniond q_roll(Eigen::AngleAxisd(s.x[3], Vector3d::UnitX()));
    const Eigen::Quaterniond q_pitch(Eigen::AngleAxisd(s.x[4], Vector3d::UnitY()));
    const Eigen::Quaterniond q_yaw(Eigen::AngleAxisd(s.x[5], Vector3d::UnitZ()));
    Eigen::Matrix3d R_F_B;  // columns: the sensor's x, y, z in F
    R_F_B << 0, 0, 1, 0, -1, 0, 1, 0, 0;
    const Eigen::Quaterniond q_F_B(R_F_B);
    FlightState out;
    out.T_W_B = {(q_yaw * q_pitch * q_roll * q_F_B).normalized(), s.x.head<3>()};
    out.v_W = s.d1.head<3>();
    out.a_W = s.d2.head<3>();
    // w_F = Rx^T (Ry^T (e_z yaw') + e_y pitch') + e_x roll'
    const Vector3d w_F =
        q_roll.conjugate() * (q_pitch.conjugate() * Vector3d(0, 0, s.d1[5]) + Vector3d(0, s.d1[4], 0)) +
        Vector3d(s.d1[3], 0, 0);
    out.w_B = q_F_B.conjugate() * w_F;
    return out;
}

FlightReport inspect_flight(const Flight& flight, const Scene& scene) {
    FlightReport report;
    report.min_clearance_m = 1e9;
    Vector3d previous = flight.evaluate(0.0).T_W_B.p;
    for (double t = 0.0; t <= flight.duration_s(); t += kInspectStep_s) {
        const FlightState s = flight.evaluate(t);
        report.min_clearance_m = std::min(report.min_clearance_m, scene.clearance(s.T_W_B.p, 10.0));
        report.max_speed_m_per_s = std::max(report.max_speed_m_per_s, s.v_W.norm());
        report.max_rate_rad_per_s = std::max(report.max_rate_rad_per_s, s.w_B.norm());
        report.max_acceleration_m_per_s2 = std::max(report.max_acceleration_m_per_s2, s.a_W.norm());
        report.path_m += (s.T_W_B.p - previous).norm();
        previous = s.T_W_B.p;
    }
    return report;
}

Status plan_flight(const Scene& scene, const FlightPlan& plan, Flight& flight) {
    for (int draw = 0; draw < kMaxDraws; ++draw) {
        Flight candidate = Pilot(scene, plan, hash64(plan.seed, static_cast<std::uint64_t>(draw))).fly();
        const FlightReport report = inspect_flight(candidate, scene);
        if (report.min_clearance_m >= scene.flight_volume().clearance_m &&
            report.max_speed_m_per_s <= plan.max_speed_m_per_s &&
            report.max_rate_rad_per_s <= plan.max_rate_rad_per_s) {
            flight = std::move(candidate);
            return Status::kOk;
        }
    }
    return Status::kDegenerate;
}

}  // namespace facet::sim
