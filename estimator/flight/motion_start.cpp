// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/flight/motion_start.h"

#include <algorithm>
#include <cmath>

#include "estimator/geometry/stereo_precision.h"

namespace facet {
namespace {

// A window that differs this much from the closed-form solution of the same data has converged to a wrong state.
constexpr double kVelocityDifference = 0.3;  // m/s
constexpr double kTiltDifference = 0.1;      // rad
constexpr std::size_t kEnoughMotions = 3;
constexpr double kMinDisparity = 1e-3;  // normalised: points beyond 100 m at 0.1 m baseline

/// Point on the left ray from a stereo match, by least squares over both coordinates of the right one.
/// (R x + rho t) seen at xy_1: m.xy - m.z xy_1 + rho (t.xy - t.z xy_1) = 0
bool triangulate_pair(const FeatureObservation& o, const Se3& T_C1_C0, Eigen::Vector3d& p_C0) {
    const Eigen::Vector3d m = T_C1_C0.q * o.left_xy.homogeneous();
    const Eigen::Vector2d a = m.head<2>() - m.z() * o.right_xy;
    const Eigen::Vector2d b = T_C1_C0.p.head<2>() - T_C1_C0.p.z() * o.right_xy;
    const double rho = -b.dot(a) / b.squaredNorm();
    if (!(rho * T_C1_C0.p.norm() > kMinDisparity)) {
        return false;
    }
    p_C0 = o.left_xy.homogeneous() / rho;
    return true;
}

}  // namespace

void MotionStart::configure(const StereoRig& rig, const ImuNoise& noise, double gravity_m_per_s2,
                            double pixel_sigma_px) {
    rig_ = rig;
    noise_ = noise;
    gravity_m_per_s2_ = gravity_m_per_s2;
    pixel_sigma_px_ = pixel_sigma_px;
    reset();
}

void MotionStart::reset() {
    points_.clear();
    motions_.clear();
}

void MotionStart::add_keyframe(Timestamp stamp, std::span<const FeatureObservation> observations,
                               const ImuBuffer& imu) {
    const Se3 T_C1_C0 = rig_.T_B_C1.inverse() * rig_.T_B_C0;
    PointList& now = next_;
    now.clear();
    for (const FeatureObservation& o : observations) {
        Point point{o.landmark, {}};
        if (o.has_right && triangulate_pair(o, T_C1_C0, point.place.p_C0)) {
            point.place.covariance_C0 = stereo_covariance(rig_, T_C1_C0, point.place.p_C0, pixel_sigma_px_);
            now.push_back(point);
        }
    }
    std::sort(now.begin(), now.end(), [](const Point& a, const Point& b) { return a.landmark < b.landmark; });

    boost::container::static_vector<StereoPoint, kMaxFeatures> shared;
    for (std::size_t i = 0, j = 0; i < points_.size() && j < now.size();) {
        if (points_[i].landmark == now[j].landmark) {
            shared.push_back({points_[i].place, now[j].place});
            ++i;
            ++j;
        } else if (points_[i].landmark < now[j].landmark) {
            ++i;
        } else {
            ++j;
        }
    }
    KeyframeMotion motion;
    motion.imu = Preintegration({}, gravity_m_per_s2_);
    StereoMotion seen;
    const bool found = !points_.empty() && ok(imu.integrate_between(stamp_, stamp, noise_, motion.imu)) &&
                       ok(estimate_stereo_motion({shared.data(), shared.size()}, rig_.T_B_C0, motion.imu.delta_q(),
                                                 StereoMotionConfig{}, seen));
    if (found) {
        motion.p_Bk_Bj = seen.p_Bi_Bj;
        motion.p_covariance = seen.covariance.bottomRightCorner<3, 3>();
        motion.has_rotation = true;
        motion.q_Bk_Bj = seen.q_Bi_Bj;
        motion.theta_covariance = seen.covariance.topLeftCorner<3, 3>();
        if (motions_.size() == motions_.capacity()) {
            motions_.erase(motions_.begin());
        }
        motions_.push_back(motion);
    } else {
        motions_.clear();
    }
    points_.swap(next_);
    stamp_ = stamp;
}

Status MotionStart::check(const NavState& state, NavState& better,
                          Eigen::Matrix<double, kStateDim, kStateDim>& information) const {
    DynamicInit solution;
    if (motions_.size() < kEnoughMotions ||
        !ok(initialize_in_motion({motions_.data(), motions_.size()}, DynamicInitConfig{}, solution))) {
        return Status::kNotFound;
    }
    // Yaw and position are chosen by the window: compare velocity and the direction of gravity in the body frame.
    const NavState& other = solution.initial.state;
    const Eigen::Vector3d v_B = state.q_W_B.conjugate() * state.v_W_B;
    const Eigen::Vector3d v_B_other = other.q_W_B.conjugate() * other.v_W_B;
    const Eigen::Vector3d up_B = state.q_W_B.conjugate() * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d up_B_other = other.q_W_B.conjugate() * Eigen::Vector3d::UnitZ();
    const double tilt = std::atan2(up_B.cross(up_B_other).norm(), up_B.dot(up_B_other));
    if (!((v_B - v_B_other).norm() > kVelocityDifference || tilt > kTiltDifference)) {
        return Status::kNotFound;
    }
    // Turns the solution's world about the vertical and moves it, so that yaw and position stay as they are.
    const Eigen::Matrix3d turn = (state.q_W_B * other.q_W_B.conjugate()).toRotationMatrix();
    const double yaw = std::atan2(turn(1, 0) - turn(0, 1), turn(0, 0) + turn(1, 1));
    const Eigen::Quaterniond q_yaw(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
    better = other;
    better.q_W_B = (q_yaw * other.q_W_B).normalized();
    better.p_W_B = state.p_W_B;
    better.v_W_B = q_yaw * other.v_W_B;
    Eigen::Matrix<double, kStateDim, kStateDim> to_world = Eigen::Matrix<double, kStateDim, kStateDim>::Identity();
    to_world.block<3, 3>(kVel, kVel) = q_yaw.toRotationMatrix();
    to_world.block<3, 3>(kPos, kPos) = to_world.block<3, 3>(kVel, kVel);
    information = to_world * solution.initial.information() * to_world.transpose();
    return Status::kOk;
}

}  // namespace facet
