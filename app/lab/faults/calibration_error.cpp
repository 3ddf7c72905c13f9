// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/faults/calibration_error.h"

#include <Eigen/Core>
#include <cmath>

#include "app/support/rng.h"
#include "estimator/geometry/so3.h"

namespace facet {
namespace {

constexpr std::uint64_t kPurpose = 43;  // of the random numbers, the left camera's; the right one has the next

/// Student's t with three degrees of freedom: a normal number over the root of the mean square of three others.
double heavy_tailed(RandomStream& random) {
    const double value = random.normal();
    double squares = 0.0;
    for (int i = 0; i < 3; ++i) {
        squares += std::pow(random.normal(), 2);
    }
    return value / std::sqrt(squares / 3.0);
}

/// @return whether the camera can be used (otherwise untouched)
bool disturb(const CalibrationSigmas& sigmas, double factor, ErrorDraw draw, RandomStream& random, CameraModel& camera,
             Se3& T_B_C) {
    const auto error = [&](double sigma) {
        return factor * sigma * (draw == ErrorDraw::kTails ? heavy_tailed(random) : random.normal());
    };
    CameraIntrinsics k = camera.intrinsics();
    k.fx *= 1.0 + error(sigmas.focal);
    k.fy *= 1.0 + error(sigmas.focal);
    k.cx += error(sigmas.principal_px);
    k.cy += error(sigmas.principal_px);
    const double k1 = error(sigmas.radial);
    const double k2 = error(sigmas.radial);
    const double p1 = error(sigmas.tangential);
    const double p2 = error(sigmas.tangential);
    k.coeffs[0] += coefficient_count(k.distortion) > 0 ? k1 : 0.0;
    k.coeffs[1] += coefficient_count(k.distortion) > 1 ? k2 : 0.0;
    if (coefficient_count(k.distortion) > 2 && k.distortion != Distortion::kEquidistant) {
        k.coeffs[2] += p1;
        k.coeffs[3] += p2;
    }
    Eigen::Vector3d turn;
    Eigen::Vector3d shift;
    for (int axis = 0; axis < 3; ++axis) {
        turn(axis) = error(sigmas.rotation_rad);
    }
    for (int axis = 0; axis < 3; ++axis) {
        shift(axis) = error(sigmas.place_m);
    }
    if (!ok(CameraModel::validate(k))) {
        return false;
    }
    camera = CameraModel(k);
    T_B_C.q = (T_B_C.q * so3_exp(turn)).normalized();
    T_B_C.p += shift;
    return true;
}

}  // namespace

bool add_calibration_error(double factor, std::uint64_t seed, StereoRig& rig, ErrorDraw draw,
                           const CalibrationSigmas& sigmas) {
    StereoRig wrong = rig;
    RandomStream left(seed, kPurpose);
    RandomStream right(seed, kPurpose + 1);
    if (!disturb(sigmas, factor, draw, left, wrong.left, wrong.T_B_C0) ||
        !disturb(sigmas, factor, draw, right, wrong.right, wrong.T_B_C1) || !(wrong.baseline_m() > 1e-3)) {
        return false;
    }
    rig = wrong;
    return true;
}

}  // namespace facet
