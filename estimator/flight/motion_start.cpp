// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/flight/motion_start.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "estimator/geometry/so3.h"

namespace facet {
namespace {

// With one camera; before that any motion looks like one at constant velocity.
constexpr std::size_t kFewestAlone = 5;
constexpr double kShortestAlone_s = 0.7;
constexpr std::size_t kFewestStereo = 4;
constexpr int kFewestPoints = 12;
constexpr std::size_t kFewestSights = 3;  // of a point: fewer say nothing of the motion
constexpr int kSteps = 5;
constexpr double kLeastDepth_m = 0.1;
constexpr int kVelocityAt = 0;
constexpr int kGravityAt = 3;
constexpr int kAccelBiasAt = 6;
constexpr int kGyroBiasAt = 9;
// Priors, wide: a drone's speed, gravity from a mean of forces, biases before a flight.
constexpr double kVelocitySigma = 5.0;
constexpr double kGravitySigma = 4.0;
constexpr double kAccelBiasSigma = 0.1;
constexpr double kGyroBiasSigma = 0.02;
constexpr double kGravityNormSigma = 0.02;
// What a solution must know, and by how much it must differ from the window to overrule it.
constexpr double kMostVelocitySigma = 0.3;
constexpr double kMostTiltSigma = 0.1;
constexpr double kMostSpeed = 20.0;
constexpr double kMostAccelBias = 0.5;
constexpr double kOtherVelocity = 0.3;
constexpr double kOtherTilt = 0.1;
// The sightings' errors are not independent from keyframe to keyframe: the covariance is raised by this.
constexpr double kCaution = 4.0;
constexpr double kGaugeSigma = 1e-4;

}  // namespace

void MotionStart::configure(const StereoRig& rig, const ImuNoise& noise, double gravity_m_per_s2,
                            double bearing_sigma) {
    rig_ = rig;
    noise_ = noise;
    gravity_m_per_s2_ = gravity_m_per_s2;
    bearing_sigma_ = bearing_sigma;
    reset();
}

void MotionStart::add_keyframe(Timestamp stamp, std::span<const FeatureObservation> observations, const ImuBuffer& imu,
                               const ImuBias& bias) {
    Preintegration link(bias, gravity_m_per_s2_);
    if (!keyframes_.empty() && !ok(imu.integrate_between(keyframes_.back().stamp, stamp, noise_, link))) {
        keyframes_.clear();
    }
    if (keyframes_.size() == keyframes_.capacity()) {
        keyframes_.erase(keyframes_.begin());
    }
    keyframes_.emplace_back();
    View& view = keyframes_.back();
    view.stamp = stamp;
    view.link = link;
    for (const FeatureObservation& o : observations) {
        if (view.bearings.size() < view.bearings.capacity()) {
            Bearing bearing{o.landmark, rig_.T_B_C0.q * o.left_xy.homogeneous().normalized(), {0.0, 0.0, 0.0}};
            if (o.has_right) {
                bearing.right_B = rig_.T_B_C1.q * o.right_xy.homogeneous().normalized();
            }
            view.bearings.push_back(bearing);
        }
    }
    std::sort(view.bearings.begin(), view.bearings.end(),
              [](const Bearing& a, const Bearing& b) { return a.landmark < b.landmark; });
}

MotionStart::Places MotionStart::chain(const ImuBias& bias) const {
    Places places;
    places.emplace_back();
    for (std::size_t k = 1; k < keyframes_.size(); ++k) {
        const Preintegration& link = keyframes_[k].link;
        const Place& i = places.back();
        Eigen::Quaterniond dq;
        Eigen::Vector3d dp;
        Eigen::Vector3d dv;
        link.corrected(bias, dq, dp, dv);
        const double dt = link.dt_s();
        const Eigen::Matrix3d turn = dq.toRotationMatrix();
        const auto& j_link = link.d_delta_d_bias();
        // Turning the body frame at i by a bias error turns what follows.
        const Eigen::Matrix3d turned_p = -i.R * skew(dp) * i.d_theta_d_bg;
        const Eigen::Matrix3d turned_v = -i.R * skew(dv) * i.d_theta_d_bg;
        Place j;
        j.t_s = i.t_s + dt;
        j.R = i.R * turn;
        j.d_theta_d_bg = turn.transpose() * i.d_theta_d_bg + j_link.block<3, 3>(kTheta, 0);
        j.p = i.p + i.v * dt + i.R * dp;
        j.v = i.v + i.R * dv;
        j.d_p_d_b = i.d_p_d_b + i.d_v_d_b * dt + i.R * j_link.middleRows<3>(kPos);
        j.d_v_d_b = i.d_v_d_b + i.R * j_link.middleRows<3>(kVel);
        j.d_p_d_b.leftCols<3>() += turned_p;
        j.d_v_d_b.leftCols<3>() += turned_v;
        places.push_back(j);
    }
    return places;
}

/// d_c_d_x; an error of the gyroscope bias turns the bearing, which counts as a move of the centre at this depth.
MotionStart::Centre MotionStart::centre_of(const Sight& sight, double depth) {
    const Place& k = *sight.place;
    Centre m;
    m.middleCols<3>(kVelocityAt) = k.t_s * Eigen::Matrix3d::Identity();
    m.middleCols<3>(kGravityAt) = 0.5 * k.t_s * k.t_s * Eigen::Matrix3d::Identity();
    m.middleCols<3>(kAccelBiasAt) = k.d_p_d_b.rightCols<3>();
    const Eigen::Vector3d d_B = k.R.transpose() * sight.d;
    m.middleCols<3>(kGyroBiasAt) = k.d_p_d_b.leftCols<3>() - k.R * skew(*sight.p_B_C + depth * d_B) * k.d_theta_d_bg;
    return m;
}

/// Adds the normal equations of one point, itself eliminated.
void MotionStart::add_point(const Sights& sights, int step, const Unknowns& last, Solution& sums,
                            Unknowns& gradient) const {
    boost::container::static_vector<double, 2 * kMostKeyframes> depths(sights.size(), 1.0);
    boost::container::static_vector<double, 2 * kMostKeyframes> weights(sights.size(), 1.0);
    const auto offset = [](const Sight& s) -> Eigen::Vector3d { return s.place->p + s.place->R * *s.p_B_C; };
    for (int pass = step == 0 ? 1 : 0; pass < 2; ++pass) {
        // Pass 0 finds the point at the last solution, for depths and weights; pass 1 adds the equations.
        Eigen::Matrix3d a = 1e-9 * Eigen::Matrix3d::Identity();
        Eigen::Matrix<double, 3, kUnknowns> am = Eigen::Matrix<double, 3, kUnknowns>::Zero();
        Eigen::Vector3d ab = Eigen::Vector3d::Zero();
        Normal mm = Normal::Zero();
        Unknowns mb = Unknowns::Zero();
        for (std::size_t k = 0; k < sights.size(); ++k) {
            const Sight& s = sights[k];
            const Eigen::Matrix3d p = weights[k] * (Eigen::Matrix3d::Identity() - s.d * s.d.transpose());
            const Centre m = centre_of(s, pass == 0 || step == 0 ? 0.0 : depths[k]);
            const Eigen::Vector3d b = offset(s);
            a += p;
            am.noalias() += p * m;
            ab += p * b;
            if (pass == 1) {
                mm.noalias() += m.transpose() * (p * m);
                mb.noalias() += m.transpose() * (p * b);
            }
        }
        const Eigen::Matrix3d a_inverse = a.inverse();
        if (pass == 1) {
            sums.information += mm - am.transpose() * a_inverse * am;
            gradient += mb - am.transpose() * (a_inverse * ab);
            ++sums.points;
            continue;
        }
        Unknowns without_turn = last;
        without_turn.segment<3>(kGyroBiasAt).setZero();
        const Eigen::Vector3d point = a_inverse * (am * without_turn + ab);
        bool behind = false;
        for (std::size_t k = 0; k < sights.size(); ++k) {
            const Sight& s = sights[k];
            const Eigen::Vector3d ray = point - centre_of(s, 0.0) * without_turn - offset(s);
            const double depth = s.d.dot(ray);
            behind = behind || depth < kLeastDepth_m;
            depths[k] = std::max(depth, kLeastDepth_m);
            const double scale = depths[k] * bearing_sigma_;
            const double error = (ray - depth * s.d).norm() / scale;
            ++sums.sightings;
            sums.misfits += error > 3.0 ? 1 : 0;
            weights[k] = 1.0 / (scale * scale * (1.0 + 0.25 * error * error));
        }
        sums.behind += behind ? 1 : 0;
    }
}

MotionStart::Sights MotionStart::sights_of(LandmarkId landmark, const Places& places) const {
    Sights sights;
    for (std::size_t k = 0; k < keyframes_.size(); ++k) {
        const auto& bearings = keyframes_[k].bearings;
        const auto at = std::lower_bound(bearings.begin(), bearings.end(), landmark,
                                         [](const Bearing& b, LandmarkId id) { return b.landmark < id; });
        if (at == bearings.end() || at->landmark != landmark) {
            continue;
        }
        sights.push_back({places[k].R * at->left_B, &places[k], &rig_.T_B_C0.p});
        if (at->has_right()) {
            sights.push_back({places[k].R * at->right_B, &places[k], &rig_.T_B_C1.p});
        }
    }
    return sights;
}

bool MotionStart::has_stereo() const {
    const auto& bearings = keyframes_[keyframes_.size() / 2].bearings;
    return 2 * std::count_if(bearings.begin(), bearings.end(), [](const Bearing& b) { return b.has_right(); }) >
           static_cast<std::ptrdiff_t>(bearings.size());
}

Status MotionStart::iterate(const Places& places, int step, Solution& solution) const {
    Solution sums;
    Unknowns gradient = Unknowns::Zero();
    // Points are taken from the keyframe in the middle: most are seen on both sides of it.
    for (const Bearing& bearing : keyframes_[keyframes_.size() / 2].bearings) {
        if (sums.points >= static_cast<int>(kMostPoints)) {
            break;
        }
        const Sights sights = sights_of(bearing.landmark, places);
        if (sights.size() >= kFewestSights) {
            add_point(sights, step, solution.x, sums, gradient);
        }
    }
    if (sums.points < kFewestPoints) {
        return Status::kNotReady;
    }
    if (step == 0) {  // depths are unknown yet: as if all were at 2 m
        const double scale = 2.0 * bearing_sigma_;
        sums.information /= scale * scale;
        gradient /= scale * scale;
    }
    Unknowns prior;
    prior.segment<3>(kVelocityAt).setConstant(kVelocitySigma);
    prior.segment<3>(kGravityAt).setConstant(kGravitySigma);
    prior.segment<3>(kAccelBiasAt).setConstant(kAccelBiasSigma);
    prior.segment<3>(kGyroBiasAt).setConstant(step == 0 ? 1e-6 : kGyroBiasSigma);
    sums.information.diagonal() += prior.cwiseAbs2().cwiseInverse();
    // Gravity's prior is the negative mean force, at which the vehicle neither falls nor climbs for long.
    const Place& newest = places.back();
    gradient.segment<3>(kGravityAt) += newest.v / newest.t_s / (kGravitySigma * kGravitySigma);
    if (step > 0) {
        const Eigen::Vector3d along = solution.x.segment<3>(kGravityAt).normalized();
        const double weight = 1.0 / (kGravityNormSigma * kGravityNormSigma);
        sums.information.block<3, 3>(kGravityAt, kGravityAt) += weight * along * along.transpose();
        gradient.segment<3>(kGravityAt) -= weight * gravity_m_per_s2_ * along;
    }
    const Eigen::LLT<Normal> llt(sums.information);
    if (llt.info() != Eigen::Success) {
        return Status::kDegenerate;
    }
    sums.x = -llt.solve(gradient);
    solution = sums;
    return sums.x.allFinite() ? Status::kOk : Status::kDegenerate;
}

bool MotionStart::is_known(const Solution& solution, const Place& newest) const {
    const Normal covariance = kCaution * solution.information.inverse();
    Centre d_v = Centre::Zero();
    d_v.middleCols<3>(kVelocityAt).setIdentity();
    d_v.middleCols<3>(kGravityAt) = newest.t_s * Eigen::Matrix3d::Identity();
    d_v.middleCols<3>(kAccelBiasAt) = newest.d_v_d_b.rightCols<3>();
    const Eigen::Matrix3d velocity = d_v * covariance * d_v.transpose();
    const Eigen::Matrix3d gravity = covariance.block<3, 3>(kGravityAt, kGravityAt);
    return std::sqrt(velocity.diagonal().maxCoeff()) < kMostVelocitySigma &&
           std::sqrt(gravity.diagonal().maxCoeff()) / gravity_m_per_s2_ < kMostTiltSigma;
}

bool MotionStart::fits(const Solution& solution) {
    const Unknowns& x = solution.x;
    return 5 * solution.behind < solution.points && 4 * solution.misfits < solution.sightings &&
           x.segment<3>(kVelocityAt).norm() < kMostSpeed && x.segment<3>(kAccelBiasAt).norm() < kMostAccelBias;
}

Status MotionStart::solve(const NavState& state, NavState& solved, Information& information) const {
    if (keyframes_.size() < kFewestStereo) {
        return Status::kNotReady;
    }
    const double duration_s = (keyframes_.back().stamp - keyframes_.front().stamp).seconds();
    if (!has_stereo() && (keyframes_.size() < kFewestAlone || duration_s < kShortestAlone_s)) {
        return Status::kNotReady;
    }
    ImuBias bias{keyframes_.front().link.bias().gyro, Eigen::Vector3d::Zero()};
    Places places = chain(bias);
    Solution solution;
    for (int step = 0; step < kSteps; ++step) {
        FACET_TRY(iterate(places, step, solution));
        if (step + 1 < kSteps) {
            bias.gyro += solution.x.segment<3>(kGyroBiasAt);
            places = chain(bias);
        }
    }
    const Place& newest = places.back();
    if (!is_known(solution, newest) || !fits(solution)) {
        return Status::kDegenerate;
    }
    const Eigen::Vector3d g_B0 = solution.x.segment<3>(kGravityAt);
    const Eigen::Vector3d accel = solution.x.segment<3>(kAccelBiasAt);
    const Eigen::Vector3d v_B0 =
        solution.x.segment<3>(kVelocityAt) + g_B0 * newest.t_s + newest.v + newest.d_v_d_b.rightCols<3>() * accel;
    // Yaw is the window's: the least turn that makes the solution's gravity vertical.
    const Eigen::Quaterniond q_B0_B(newest.R);
    const Eigen::Vector3d up_B = q_B0_B.conjugate() * (-g_B0.normalized());
    const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(state.q_W_B * up_B, Eigen::Vector3d::UnitZ());
    NavState out;
    out.q_W_B = (turn * state.q_W_B).normalized();
    out.p_W_B = state.p_W_B;
    out.v_W_B = out.q_W_B * (q_B0_B.conjugate() * v_B0);
    out.bias = {bias.gyro + solution.x.segment<3>(kGyroBiasAt), accel};

    const Normal covariance = kCaution * solution.information.inverse();
    const double tilt =
        std::sqrt(covariance.block<3, 3>(kGravityAt, kGravityAt).diagonal().maxCoeff()) / gravity_m_per_s2_;
    information.setZero();
    const Eigen::Vector3d inverse_W(1.0 / tilt, 1.0 / tilt, 1.0 / kGaugeSigma);
    const Eigen::Matrix3d theta = inverse_W.asDiagonal() * out.q_W_B.toRotationMatrix();
    information.block<3, 3>(kTheta, kTheta) = theta.transpose() * theta;
    information.diagonal().segment<3>(kPos).setConstant(1.0 / (kGaugeSigma * kGaugeSigma));
    information.diagonal().segment<3>(kVel).setConstant(1.0 / (kMostVelocitySigma * kMostVelocitySigma));
    information.diagonal().segment<3>(kBiasGyro).setConstant(1.0 / (kGyroBiasSigma * kGyroBiasSigma));
    information.diagonal().segment<3>(kBiasAccel).setConstant(1.0 / (kAccelBiasSigma * kAccelBiasSigma));
    solved = out;
    return Status::kOk;
}

Status MotionStart::check(const NavState& state, NavState& better, Information& information) const {
    NavState other;
    Information other_information;
    FACET_TRY(solve(state, other, other_information));
    const Eigen::Vector3d v_B = state.q_W_B.conjugate() * state.v_W_B;
    const Eigen::Vector3d v_B_other = other.q_W_B.conjugate() * other.v_W_B;
    const Eigen::Vector3d up_B = state.q_W_B.conjugate() * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d up_B_other = other.q_W_B.conjugate() * Eigen::Vector3d::UnitZ();
    const double tilt = std::atan2(up_B.cross(up_B_other).norm(), up_B.dot(up_B_other));
    if (!((v_B - v_B_other).norm() > kOtherVelocity || tilt > kOtherTilt)) {
        return Status::kNotFound;
    }
    better = other;
    information = other_information;
    return Status::kOk;
}

}  // namespace facet
