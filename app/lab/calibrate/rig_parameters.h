// SPDX-License-Identifier: BSD-2-Clause
// The calibration as a vector of corrections to a given one, and what each entry means.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app/calibration/calibration.h"
#include "estimator/geometry/lens_correction.h"

namespace facet {

/// Corrections of a given calibration: of a camera's lens (LensCorrection), of its pose on the body [theta p] as
/// Se3::box_plus, and of the time offset, t_imu = t_image + offset (s).
inline constexpr int kBatchLensDim = kLensDim;
inline constexpr int kBatchMountDim = 6;

/// Offsets in the vector of all corrections.
inline constexpr std::array<int, 2> kBatchLens{0, kBatchLensDim};  ///< by camera
inline constexpr std::array<int, 2> kBatchMount{2 * kBatchLensDim, 2 * kBatchLensDim + kBatchMountDim};
inline constexpr int kBatchTime = 2 * (kBatchLensDim + kBatchMountDim);
inline constexpr int kBatchDim = kBatchTime + 1;
using RigVector = Eigen::Matrix<double, kBatchDim, 1>;

/// What a corrected calibration consists of.
struct RigAndTime {
    StereoRig rig;
    double time_shift_s = 0.0;  ///< t_imu = t_cam + shift
};

/// @return kInvalidArgument if a corrected lens is no usable camera (out untouched). Reentrant.
Status apply_correction(const RigAndTime& given, const RigVector& correction, RigAndTime& out);

/// Standard deviations of the given calibration before the flight is looked at, times `scale`: 10 sigma of a good
/// calibration (CalibrationSigmas), so that the flight decides, but 3 sigma for the cameras' positions, which a
/// ruler shows better than a flight. 0 for coefficients that a lens does not have.
RigVector prior_sigmas(const StereoRig& rig, double scale);

/// What a good calibration with a target leaves, for the same entries.
RigVector good_sigmas(const StereoRig& rig);

/// What the flight says of a parameter.
enum class ParameterVerdict : std::uint8_t {
    kFound,          ///< at least as well known as after a good calibration with a target
    kWeak,           ///< better known than before, but not that well
    kNotObservable,  ///< hardly better known than before: the given value is kept
};

/// Least share of the prior's sigma that must go for a parameter to count as seen in the flight.
inline constexpr double kUnseenShare = 0.7;

/// A parameter in the units that files and people use.
struct RigParameter {
    std::string name;             ///< such as "cam0.cx"
    std::string_view unit = "-";  ///< a literal; "-" if it has none
    double given = 0.0;           ///< of a rotation, 0: `refined` is then the turn from the given one
    double refined = 0.0;
    double sigma = 0.0;
    double prior_sigma = 0.0;
    ParameterVerdict verdict = ParameterVerdict::kNotObservable;
    std::string advice;  ///< what to fly to know it better
};

/// Verdict of one entry by its standard deviations.
ParameterVerdict judge_parameter(double sigma, double prior_sigma, double good_sigma);

/// All parameters that the rig has, in the order of the vector.
std::vector<RigParameter> describe_parameters(const RigAndTime& given, const RigVector& correction,
                                              const RigVector& sigma, const RigVector& prior);

const char* to_string(ParameterVerdict verdict);

}  // namespace facet
