// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/calibration_prior.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace facet {

CalibrationMatrix calibration_covariance(const CalibrationConfig& config, const StereoRig& given) {
    const int dim = config.dim();
    CalibrationMatrix covariance = CalibrationMatrix::Zero(dim, dim);
    for (int i = 0; i < dim; ++i) {
        covariance(i, i) = std::pow(config.sigma(i), 2);
    }
    if (!config.estimate_cameras) {
        return covariance;
    }
    const double theta = std::pow(config.camera_rotation_sigma_rad, 2);
    const double place = std::pow(config.camera_position_sigma_m, 2);
    const Eigen::Matrix3d cross = -theta * given.T_B_C1.R();
    covariance.block<3, 3>(kRigTheta, kRightTheta) = cross;
    covariance.block<3, 3>(kRightTheta, kRigTheta) = cross.transpose();
    for (int i = 0; i < 3; ++i) {
        covariance(kRigPos + i, kRightPos + i) = -place;
        covariance(kRightPos + i, kRigPos + i) = -place;
    }
    return covariance;
}

bool invert_covariance(const CalibrationMatrix& covariance, CalibrationMatrix& information) {
    const Eigen::LLT<CalibrationMatrix> llt(covariance);
    if (!covariance.allFinite() || llt.info() != Eigen::Success) {
        return false;
    }
    CalibrationMatrix inverse = CalibrationMatrix::Identity(covariance.rows(), covariance.rows());
    llt.solveInPlace(inverse);
    information = 0.5 * (inverse + inverse.transpose());
    return true;
}

}  // namespace facet
