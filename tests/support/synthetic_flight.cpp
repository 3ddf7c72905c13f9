// SPDX-License-Identifier: BSD-2-Clause
#include "tests/support/synthetic_flight.h"

#include <array>
#include <cmath>

#include "tests/support/ideal_camera.h"

namespace facet::test {
namespace {

constexpr double kPi = 3.14159265358979323846;

constexpr double kYawRate = 0.4;  // of the swings (rad/s)
constexpr double kPitchRate = 0.9;
constexpr double kRollRate = 1.1;
constexpr double kRollPhase = 0.3;
const Eigen::Vector3d kRate{0.7, 0.9, 1.3};

/// Attitude as yaw-pitch-roll of sines; rates by the chain rule.
Eigen::Quaterniond attitude(const SyntheticMotion& motion, double t) {
    const double yaw = motion.yaw_rad * std::sin(kYawRate * t);
    const double pitch = motion.pitch_rad * std::sin(kPitchRate * t);
    const double roll = motion.roll_rad * std::sin(kRollRate * t + kRollPhase);
    return Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
           Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX());
}

Eigen::Vector3d body_rate(const SyntheticMotion& motion, double t) {
    const double yaw_rate = motion.yaw_rad * kYawRate * std::cos(kYawRate * t);
    const double pitch = motion.pitch_rad * std::sin(kPitchRate * t);
    const double pitch_rate = motion.pitch_rad * kPitchRate * std::cos(kPitchRate * t);
    const double roll = motion.roll_rad * std::sin(kRollRate * t + kRollPhase);
    const double roll_rate = motion.roll_rad * kRollRate * std::cos(kRollRate * t + kRollPhase);
    const Eigen::AngleAxisd r_x(-roll, Eigen::Vector3d::UnitX());
    const Eigen::AngleAxisd r_y(-pitch, Eigen::Vector3d::UnitY());
    return roll_rate * Eigen::Vector3d::UnitX() + r_x * (pitch_rate * Eigen::Vector3d::UnitY()) +
           r_x * (r_y * (yaw_rate * Eigen::Vector3d::UnitZ()));
}

/// The room's sides: half lengths 5, 4, 2.5 m about the origin.
const Eigen::Vector3d kRoom{5.0, 4.0, 2.5};
struct Side {
    PlaneKind kind;
    Eigen::Vector3d normal_W;
    double distance_m;
};
const std::array<Side, 6> kSides{{{PlaneKind::kHorizontal, {0, 0, 1}, -2.5},
                                  {PlaneKind::kHorizontal, {0, 0, -1}, -2.5},
                                  {PlaneKind::kVertical, {-1, 0, 0}, -5.0},
                                  {PlaneKind::kVertical, {1, 0, 0}, -5.0},
                                  {PlaneKind::kVertical, {0, -1, 0}, -4.0},
                                  {PlaneKind::kVertical, {0, 1, 0}, -4.0}}};

}  // namespace

StereoRig make_rig() {
    StereoRig rig;
    rig.left = rig.right = ideal_camera(752, 480, 458.0);
    // Camera z along body x, camera x along body -y.
    Eigen::Matrix3d R_B_C;
    R_B_C << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    rig.T_B_C0 = {Eigen::Quaterniond(R_B_C), {0.05, 0.055, 0.01}};
    rig.T_B_C1 = {Eigen::Quaterniond(R_B_C) * so3_exp({0.01, -0.008, 0.005}), {0.05, -0.055, 0.012}};
    return rig;
}

ImuNoise euroc_like_noise() {
    ImuNoise noise;
    noise.gyro_noise_rad_per_s_per_sqrt_hz = 1.7e-4;
    noise.accel_noise_m_per_s2_per_sqrt_hz = 2e-3;
    return noise;
}

Eigen::Matrix<double, kStateDim, 1> start_sigmas() {
    Eigen::Matrix<double, kStateDim, 1> sigma;
    sigma << 0.02, 0.02, 1e-4, 1e-4, 1e-4, 1e-4, 0.1, 0.1, 0.1, 0.01, 0.01, 0.01, 0.05, 0.05, 0.05;
    return sigma;
}

SyntheticFlight::SyntheticFlight(const Options& options)
    : options_(options), rig_(make_rig()), true_rig_(rig_), generator_(options.seed) {
    const Se3 turn{so3_exp(options.rig_rotation), Eigen::Vector3d::Zero()};
    true_rig_.T_B_C0 = turn * rig_.T_B_C0;
    true_rig_.T_B_C1 = turn * rig_.T_B_C1;
    std::uniform_real_distribution<double> angle(-kPi, kPi);
    std::uniform_real_distribution<double> radius(3.5, 7.0);
    std::uniform_real_distribution<double> height(-2.5, 2.5);
    for (int i = 0; i < options.landmarks && options.in_room; ++i) {
        const Side& side = kSides[static_cast<std::size_t>(i) % kSides.size()];
        std::uniform_real_distribution<double> share(-1.0, 1.0);
        // One after the other: compilers evaluate arguments in orders of their own, and the room shall be the same.
        const double z = share(generator_);
        const double y = share(generator_);
        const double x = share(generator_);
        const Eigen::Vector3d in_box(x, y, z);
        Eigen::Vector3d p = kRoom.cwiseProduct(in_box);
        p -= side.normal_W * side.normal_W.dot(p);
        landmarks_.emplace_back(p + side.distance_m * side.normal_W);
    }
    for (int i = 0; i < options.landmarks && !options.in_room; ++i) {
        const double a = angle(generator_);
        const double r = radius(generator_);
        landmarks_.emplace_back(r * std::cos(a), r * std::sin(a), height(generator_));
    }
}

PlaneProposals SyntheticFlight::planes() const {
    PlaneProposals planes;
    for (std::size_t s = 0; s < kSides.size(); ++s) {
        PlaneProposal plane;
        plane.id = {static_cast<std::uint32_t>(s)};
        plane.kind = kSides[s].kind;
        plane.normal_W = kSides[s].normal_W;
        plane.distance_m = kSides[s].distance_m;
        for (std::size_t i = s; i < landmarks_.size() && !plane.landmarks.full(); i += kSides.size()) {
            plane.landmarks.push_back({static_cast<std::uint32_t>(i)});
        }
        planes.push_back(plane);
    }
    return planes;
}

Eigen::Vector3d SyntheticFlight::gaussian() {
    std::normal_distribution<double> normal;
    const double x = normal(generator_);
    const double y = normal(generator_);
    const double z = normal(generator_);
    return {x, y, z};
}

NavState SyntheticFlight::state(double t) const {
    NavState s;
    const SyntheticMotion& motion = options_.motion;
    const Eigen::Array3d a = motion.place_m.array();
    const Eigen::Array3d w = kRate.array();
    const Eigen::Array3d sine = (w * t).sin();
    const Eigen::Array3d cosine = (w * t).cos();
    s.q_W_B = attitude(motion, t);
    s.p_W_B = Eigen::Vector3d((a * sine).x(), (a * (1.0 - cosine)).y(), (a * sine).z()) + t * motion.velocity_m_per_s;
    s.v_W_B = Eigen::Vector3d((a * w * cosine).x(), (a * w * sine).y(), (a * w * cosine).z()) + motion.velocity_m_per_s;
    s.bias = options_.bias;
    return s;
}

Eigen::Vector3d SyntheticFlight::acceleration(double t) const {
    const Eigen::Array3d a = options_.motion.place_m.array() * kRate.array().square();
    return {-a.x() * std::sin(kRate.x() * t), a.y() * std::cos(kRate.y() * t), -a.z() * std::sin(kRate.z() * t)};
}

Eigen::Vector3d SyntheticFlight::rate(double t) const { return body_rate(options_.motion, t); }

ImuSample SyntheticFlight::imu(double t) {
    const double to_discrete = std::sqrt(options_.imu_rate_hz);
    ImuSample sample;
    sample.stamp = at(t);
    sample.w_B = rate(t) + options_.bias.gyro + options_.gyro_noise * to_discrete * gaussian();
    sample.a_B = attitude(options_.motion, t).conjugate() * (acceleration(t) - gravity_W(options_.gravity_m_per_s2)) +
                 options_.bias.accel + options_.accel_noise * to_discrete * gaussian();
    return sample;
}

std::vector<FeatureObservation> SyntheticFlight::observe(double t, int most) {
    const Se3 T_W_B = state(t + options_.time_offset_s).T_W_B();
    const Se3 T_C0_W = (T_W_B * true_rig_.T_B_C0).inverse();
    const Se3 T_C1_W = (T_W_B * true_rig_.T_B_C1).inverse();
    const double sigma = options_.pixel_sigma / rig_.left.focal_px();
    std::vector<FeatureObservation> observations;
    for (std::size_t i = 0; i < landmarks_.size() && static_cast<int>(observations.size()) < most; ++i) {
        const Eigen::Vector3d p_0 = T_C0_W * landmarks_[i];
        const Eigen::Vector3d p_1 = T_C1_W * landmarks_[i];
        Eigen::Vector2d uv;
        if (!ok(rig_.left.project(p_0, uv)) || !rig_.left.in_image(uv, 5.0)) {
            continue;
        }
        FeatureObservation o;
        o.landmark = {static_cast<std::uint32_t>(i)};
        o.left_px = uv.cast<float>();
        o.left_xy = p_0.head<2>() / p_0.z() + sigma * gaussian().head<2>();
        o.has_right = ok(rig_.right.project(p_1, uv)) && rig_.right.in_image(uv, 5.0);
        if (o.has_right) {
            o.right_px = uv.cast<float>();
            o.right_xy = p_1.head<2>() / p_1.z() + sigma * gaussian().head<2>();
        }
        observations.push_back(o);
    }
    return observations;
}

Preintegration SyntheticFlight::preintegrate(double t0, double t1, const ImuBias& bias, const ImuNoise& noise) {
    const int steps = static_cast<int>(std::lround((t1 - t0) * options_.imu_rate_hz));
    Preintegration preintegration(bias, options_.believed_gravity_m_per_s2);
    ImuSample previous = imu(t0);
    for (int k = 1; k <= steps; ++k) {
        const ImuSample next = imu(t0 + (t1 - t0) * k / steps);
        (void)preintegration.integrate(previous, next, noise);
        previous = next;
    }
    return preintegration;
}

}  // namespace facet::test
