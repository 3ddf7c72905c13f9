// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/flight/motion_start.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "estimator/geometry/so3.h"

namespace facet {
namespace {

constexpr std::size_t kFewestKeyframes = 4;
constexpr int kFewestPoints = 12;
constexpr std::size_t kFewestSights = 3;  // of a point: fewer say nothing of the motion
constexpr int kSteps = 12;
// A step of less than so many standard deviations ends them.
constexpr double kSmallStep = 0.1;
constexpr double kLeastDamping = 1e-3;  // of a step that has failed, as a share of the diagonal
constexpr double kMoreDamping = 10.0;
constexpr double kLessDamping = 0.1;
constexpr int kVelocityAt = MotionProblem::kVelocityAt;
constexpr int kGravityAt = MotionProblem::kGravityAt;
constexpr int kAccelBiasAt = MotionProblem::kAccelBiasAt;
constexpr int kGyroBiasAt = MotionProblem::kGyroBiasAt;
constexpr int kDelayAt = MotionProblem::kDelayAt;
// Of a delay of images, which is sought only where sightings do not fit without one.
constexpr double kNoDelay_s = 1e-6;
constexpr double kDelaySigma_s = 0.03;
constexpr Duration kRateSpan = Duration::from_seconds(0.02);
// What a solution must know, and by how much it must differ from the window to overrule it.
constexpr double kMostVelocitySigma = 0.3;
constexpr double kMostTiltSigma = 0.1;
constexpr double kMostScaleSigma = 0.05;
// Of a right solution at most one sighting in fifty is off by 3 sigma; where images are 50 ms late, one in fourteen to
// one in three.
constexpr int kSightsPerMisfit = 20;
constexpr double kMostSpeed = 20.0;
constexpr double kMostAccelBias = 0.5;
constexpr double kOtherVelocity = 0.3;
constexpr double kOtherTilt = 0.1;
// The sightings' errors are not independent from keyframe to keyframe: the covariance is raised by this.
constexpr double kCaution = 4.0;
constexpr double kGaugeSigma = 1e-4;
// Of biases before a flight (m/s^2, rad/s).
constexpr double kUnknownAccelBias = 0.1;
constexpr double kUnknownGyroBias = 0.02;

MotionProblem::BiasPrior bias_prior_of(const Belief& belief) {
    MotionProblem::BiasPrior prior;
    const auto sigma = belief.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
    prior.mean << belief.state.bias.accel, belief.state.bias.gyro;
    prior.sigma << sigma.segment<3>(kBiasAccel).cwiseMin(kUnknownAccelBias),
        sigma.segment<3>(kBiasGyro).cwiseMin(kUnknownGyroBias);
    return prior;
}

}  // namespace

void MotionStart::configure(const StereoRig& rig, const ImuNoise& noise, double gravity_m_per_s2,
                            double bearing_sigma) {
    rig_ = rig;
    noise_ = noise;
    gravity_m_per_s2_ = gravity_m_per_s2;
    problem_.configure(gravity_m_per_s2, bearing_sigma);
    reset();
}

void MotionStart::add_keyframe(Timestamp stamp, std::span<const FeatureObservation> observations, const ImuBuffer& imu,
                               const Belief& belief) {
    const ImuBias& bias = belief.state.bias;
    Preintegration link(bias, gravity_m_per_s2_);
    if (!keyframes_.empty() && !ok(imu.integrate_between(keyframes_.back().stamp, stamp, noise_, link))) {
        keyframes_.clear();
    }
    if (keyframes_.empty()) {
        bias_prior_ = bias_prior_of(belief);
    }
    if (keyframes_.size() == keyframes_.capacity()) {
        keyframes_.erase(keyframes_.begin());
    }
    keyframes_.emplace_back();
    View& view = keyframes_.back();
    view.stamp = stamp;
    view.link = link;
    Eigen::Quaterniond turn;
    if (ok(imu.rotation_between(stamp - kRateSpan, stamp, bias.gyro, turn))) {
        view.rate_B = so3_log(turn) / kRateSpan.seconds();
    }
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

MotionStart::Places MotionStart::chain(const ImuBias& bias, double delay_s) const {
    Places places;
    places.emplace_back();
    for (std::size_t k = 1; k < keyframes_.size(); ++k) {
        const Preintegration& link = keyframes_[k].link;
        const MotionPlace& i = places.back();
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
        MotionPlace j;
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
    const auto rate_B = [this](std::size_t k) -> Eigen::Vector3d {
        return keyframes_[k].rate_B.value_or(Eigen::Vector3d::Zero());
    };
    for (std::size_t k = 1; k < places.size(); ++k) {
        MotionPlace& place = places[k];
        place.d_theta_d_delay = rate_B(k) - place.R.transpose() * rate_B(0);
        place.R = place.R * so3_exp(delay_s * place.d_theta_d_delay).toRotationMatrix();
    }
    return places;
}

bool MotionStart::has_stereo() const {
    const auto& bearings = keyframes_[keyframes_.size() / 2].bearings;
    return 2 * std::count_if(bearings.begin(), bearings.end(), [](const Bearing& b) { return b.has_right(); }) >
           static_cast<std::ptrdiff_t>(bearings.size());
}

void MotionStart::collect_points() {
    problem_.clear();
    // Points are taken from the keyframe in the middle: most are seen on both sides of it.
    for (const Bearing& bearing : keyframes_[keyframes_.size() / 2].bearings) {
        boost::container::static_vector<MotionSight, MotionProblem::kMostSights> sights;
        for (std::size_t k = 0; k < keyframes_.size(); ++k) {
            const auto& bearings = keyframes_[k].bearings;
            const auto at = std::lower_bound(bearings.begin(), bearings.end(), bearing.landmark,
                                             [](const Bearing& b, LandmarkId id) { return b.landmark < id; });
            if (at == bearings.end() || at->landmark != bearing.landmark) {
                continue;
            }
            sights.push_back({&at->left_B, &rig_.T_B_C0.p, k});
            if (at->has_right()) {
                sights.push_back({&at->right_B, &rig_.T_B_C1.p, k});
            }
        }
        if (sights.size() >= kFewestSights && !problem_.add_point({sights.data(), sights.size()})) {
            break;
        }
    }
}

Status MotionStart::solve(Solution& solution) {
    collect_points();
    if (problem_.points() < kFewestPoints) {
        return Status::kNotReady;
    }
    const Status status = minimize_from_all(kNoDelay_s, solution);
    if (ok(status) && !has_stereo() && !fits(solution)) {
        find_delay(solution);
    }
    return status;
}

Status MotionStart::minimize_from_all(double delay_sigma_s, Solution& best) {
    const ImuBias bias{keyframes_.front().link.bias().gyro, Eigen::Vector3d::Zero()};
    problem_.set_delay_sigma(delay_sigma_s);
    MotionProblem::BiasPrior prior = bias_prior_;
    prior.mean.tail<3>() -= bias.gyro;  // its unknown counts from there
    problem_.set_bias_prior(prior);
    best.places = chain(bias, 0.0);
    FACET_TRY(problem_.begin(best.places, has_stereo(), best.x));
    const Status status = minimize(bias, best);
    if (has_stereo()) {
        return status;
    }
    Solution at_rest;
    at_rest.places = chain(bias, 0.0);
    problem_.begin_at_rest(at_rest.places, at_rest.x);
    if (ok(minimize(bias, at_rest)) && (!ok(status) || at_rest.sums.cost < best.sums.cost)) {
        best = at_rest;
        return Status::kOk;
    }
    return status;
}

void MotionStart::find_delay(const Solution& without) {
    const bool has_rates =
        std::all_of(keyframes_.begin(), keyframes_.end(), [](const View& v) { return v.rate_B.has_value(); });
    Solution late;
    if (has_rates && ok(minimize_from_all(kDelaySigma_s, late)) && fits(late) && late.sums.cost < without.sums.cost) {
        const double variance = kCaution * late.sums.information.inverse()(kDelayAt, kDelayAt);
        delay_ = ImageDelay{late.x(kDelayAt), std::sqrt(variance)};
    }
}

Status MotionStart::minimize(const ImuBias& bias, Solution& solution) {
    solution.sums = problem_.linearize(solution.places, solution.x);
    double damping = 0.0;
    for (int step = 0; step < kSteps; ++step) {
        Normal damped = solution.sums.information;
        damped.diagonal() *= 1.0 + damping;
        const Unknowns dx = -damped.llt().solve(solution.sums.gradient);
        if (!dx.allFinite()) {
            return Status::kDegenerate;
        }
        if (dx.dot(solution.sums.information * dx) < kSmallStep * kSmallStep) {
            break;
        }
        const Unknowns x = solution.x + dx;
        const Places places = chain({bias.gyro + x.segment<3>(kGyroBiasAt), bias.accel}, x(kDelayAt));
        const MotionProblem::Sums sums = problem_.linearize(places, x);
        if (sums.cost < solution.sums.cost) {
            solution = {x, places, sums};
            damping *= kLessDamping;
        } else {
            damping = std::max(kLeastDamping, kMoreDamping * damping);
        }
    }
    return Status::kOk;
}

MotionStart::Sigma MotionStart::sigma(const Solution& solution) const {
    const MotionPlace& newest = solution.places.back();
    const Normal covariance = kCaution * solution.sums.information.inverse();
    Eigen::Matrix<double, 3, MotionProblem::kUnknowns> d_v = decltype(d_v)::Zero();
    d_v.middleCols<3>(kVelocityAt).setIdentity();
    d_v.middleCols<3>(kGravityAt) = newest.t_s * Eigen::Matrix3d::Identity();
    d_v.middleCols<3>(kAccelBiasAt) = newest.d_v_d_b.rightCols<3>();
    Eigen::Matrix3d velocity = d_v * covariance * d_v.transpose();
    for (const View& view : keyframes_) {  // the samples' own noise, which the problem leaves out
        velocity += view.link.covariance().block<3, 3>(kVel, kVel);
    }
    const auto largest = [](const Eigen::Matrix3d& c) { return std::sqrt(c.diagonal().maxCoeff()); };
    const Unknowns d_scale = MotionProblem::d_scale_d_x(solution.places, solution.x);
    return {largest(velocity), largest(covariance.block<3, 3>(kGravityAt, kGravityAt)) / gravity_m_per_s2_,
            largest(covariance.block<3, 3>(kGyroBiasAt, kGyroBiasAt)), std::sqrt(d_scale.dot(covariance * d_scale))};
}

bool MotionStart::fits(const Solution& solution) {
    const MotionProblem::Sums& sums = solution.sums;
    return 5 * sums.behind < sums.points && kSightsPerMisfit * sums.misfits < sums.sightings &&
           solution.x.segment<3>(kVelocityAt).norm() < kMostSpeed &&
           solution.x.segment<3>(kAccelBiasAt).norm() < kMostAccelBias;
}

Status MotionStart::solve(const NavState& state, NavState& solved, Information& information) {
    delay_.reset();
    if (keyframes_.size() < kFewestKeyframes) {
        return Status::kNotReady;
    }
    Solution solution;
    FACET_TRY(solve(solution));
    const MotionPlace& newest = solution.places.back();
    const Sigma known = sigma(solution);
    const bool has_scale = has_stereo() || known.scale < kMostScaleSigma;
    if (known.velocity > kMostVelocitySigma || known.tilt > kMostTiltSigma || !has_scale || !fits(solution)) {
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
    out.bias = {keyframes_.front().link.bias().gyro + solution.x.segment<3>(kGyroBiasAt), accel};

    information.setZero();
    const Eigen::Vector3d inverse_W(1.0 / known.tilt, 1.0 / known.tilt, 1.0 / kGaugeSigma);
    const Eigen::Matrix3d theta = inverse_W.asDiagonal() * out.q_W_B.toRotationMatrix();
    information.block<3, 3>(kTheta, kTheta) = theta.transpose() * theta;
    information.diagonal().segment<3>(kPos).setConstant(1.0 / (kGaugeSigma * kGaugeSigma));
    information.diagonal().segment<3>(kVel).setConstant(1.0 / (known.velocity * known.velocity));
    information.diagonal().segment<3>(kBiasGyro).setConstant(1.0 / (known.gyro_bias * known.gyro_bias));
    information.diagonal().segment<3>(kBiasAccel) = bias_prior_.sigma.head<3>().cwiseAbs2().cwiseInverse();
    solved = out;
    return Status::kOk;
}

Status MotionStart::check(const NavState& state, NavState& better, Information& information) {
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
