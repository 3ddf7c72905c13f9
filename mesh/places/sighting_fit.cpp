// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/places/sighting_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>

namespace facet {
namespace {

/// 99 % of chi squared with two and with three degrees of freedom.
constexpr double kGateOf2 = 9.21;
constexpr double kGateOf3 = 11.34;
constexpr double kNear_m = 0.05;
/// Of the tilt between two views: an estimate's is about 1 mrad, of which 3 mm are left at a distance of 3 m.
constexpr double kTiltSigma_rad = 1e-3;
constexpr double kTiltInformation = 1.0 / (kTiltSigma_rad * kTiltSigma_rad);
/// Where the calibration is said to be exact.
constexpr double kLeastOffset = 1e-5;  ///< 1/m

double information_of(float sigma) {
    const double at_least = std::max(kLeastOffset, static_cast<double>(sigma));
    return 1.0 / (at_least * at_least);
}

}  // namespace

double SightingFit::Sighting::gate() const { return has_depth() ? kGateOf3 : kGateOf2; }

SightingFit::SightingFit(const PlaceView& seen, const PlaceView& known, double pixel)
    : seen_(seen), known_(known), R_C_G_(seen.q_G_C.toRotationMatrix().transpose().cast<double>()), pixel_(pixel) {}

void SightingFit::add(std::size_t known, const Eigen::Vector2d& xy, std::optional<std::size_t> seen) {
    const PlacePoint& point = known_.points[known];
    Sighting s{point.p_G.cast<double>(),
               static_cast<double>(known_.axis_G().dot(point.p_G)),
               static_cast<double>(point.depth_sigma),
               xy,
               0.0,
               std::numeric_limits<double>::infinity()};
    if (seen) {
        s.rho = 1.0 / point_C(*seen).z();
        s.rho_sigma = s.rho * static_cast<double>(seen_.points[*seen].depth_sigma);
    }
    sightings_.push_back(s);
}

bool SightingFit::evaluate(const Sighting& s, const State& state, Eigen::Vector3d& error, Eigen::Matrix3d& information,
                           Jacobian* jacobian) const {
    const Eigen::Matrix3d R_G_K = yaw_matrix(-state.T_K_G.yaw);
    // An inverse depth of 1 / Z + d instead of 1 / Z: the point at p (1 - Z d).
    const Eigen::Vector3d p_K = (1.0 - s.depth_K * state.known_offset) * s.p_K;
    const Eigen::Vector3d upright = R_G_K * (p_K - state.T_K_G.p);
    const Eigen::Vector3d p_G = upright + Eigen::Vector3d(state.tilt.x(), state.tilt.y(), 0.0).cross(upright);
    const Eigen::Vector3d p_C = R_C_G_ * p_G;
    if (p_C.z() < kNear_m) {
        return false;
    }
    const double rho = 1.0 / p_C.z();
    const double x = p_C.x() * rho;
    const double y = p_C.y() * rho;
    error = Eigen::Vector3d(x - s.xy.x(), y - s.xy.y(), rho - s.rho - state.seen_offset);
    Eigen::Matrix3d d_d_p;  // by the point in the camera
    d_d_p << rho, 0.0, -x * rho, 0.0, rho, -y * rho, 0.0, 0.0, -rho * rho;
    const Eigen::Matrix3d d_d_K = d_d_p * R_C_G_ * R_G_K;

    // The known point's error: along its line of sight by its depth, across it by a pixel at its distance.
    const Eigen::Vector3d along = d_d_K * s.p_K * s.depth_sigma;
    const double across = pixel_ * s.p_K.norm();
    Eigen::Matrix3d covariance = along * along.transpose() + across * across * d_d_K * d_d_K.transpose();
    covariance(0, 0) += pixel_ * pixel_;
    covariance(1, 1) += pixel_ * pixel_;
    if (s.has_depth()) {
        covariance(2, 2) += s.rho_sigma * s.rho_sigma;
        information = covariance.inverse();
    } else {
        information.setZero();
        information.topLeftCorner<2, 2>() = covariance.topLeftCorner<2, 2>().inverse();
    }
    if (jacobian != nullptr) {
        jacobian->col(0) = d_d_p * (R_C_G_ * Eigen::Vector3d(p_G.y(), -p_G.x(), 0.0));
        jacobian->middleCols<3>(1) = -d_d_K;
        jacobian->col(4) = d_d_p * (R_C_G_ * Eigen::Vector3d(0.0, -p_G.z(), p_G.y()));
        jacobian->col(5) = d_d_p * (R_C_G_ * Eigen::Vector3d(p_G.z(), 0.0, -p_G.x()));
        jacobian->col(6) = -s.depth_K * d_d_K * s.p_K;
        jacobian->col(7) = -Eigen::Vector3d::UnitZ();
    }
    return true;
}

int SightingFit::count_inliers(const State& state, double looseness) const {
    return static_cast<int>(std::ranges::count_if(sightings_, [&](const Sighting& s) {
        Eigen::Vector3d error;
        Eigen::Matrix3d information;
        return evaluate(s, state, error, information, nullptr) && error.dot(information * error) < looseness * s.gate();
    }));
}

SightingFit::Result SightingFit::step(double looseness, State& state) const {
    using Matrix = Eigen::Matrix<double, kUnknowns, kUnknowns>;
    using Vector = Eigen::Matrix<double, kUnknowns, 1>;
    Result result;
    Matrix h = 1e-9 * Matrix::Identity();
    h.diagonal().tail<4>() << kTiltInformation, kTiltInformation, information_of(known_.shared_rho_sigma),
        information_of(seen_.shared_rho_sigma);
    Vector b = Vector::Zero();
    b.tail<4>() << state.tilt, state.known_offset, state.seen_offset;
    b = -(h.diagonal().array() * b.array()).matrix();
    for (const Sighting& s : sightings_) {
        Eigen::Vector3d error;
        Eigen::Matrix3d information;
        Jacobian j;
        if (!evaluate(s, state, error, information, &j)) {
            continue;
        }
        const double squared = error.dot(information * error);
        if (squared >= looseness * s.gate()) {
            continue;
        }
        if (squared < s.gate()) {
            ++result.inliers;
            result.measurements += s.has_depth() ? 3 : 2;
            result.chi2 += squared;
        }
        const double weight = 1.0 / (1.0 + squared / s.gate());
        h += weight * j.transpose() * information * j;
        b -= weight * j.transpose() * information * error;
    }
    const Matrix covariance = h.llt().solve(Matrix::Identity());
    const Vector d = covariance * b;
    state.T_K_G = state.T_K_G.box_plus(d.head<4>());
    state.tilt += d.segment<2>(4);
    state.known_offset += d[6];
    state.seen_offset += d[7];
    result.covariance = covariance.topLeftCorner<4, 4>();
    return result;
}

}  // namespace facet
