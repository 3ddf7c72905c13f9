// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/calibrate/rig_parameters.h"

#include <fmt/core.h>

#include <numbers>

#include "app/lab/faults/calibration_error.h"

namespace facet {
namespace {

constexpr double kTimeSigmaS = 5e-4;  // what a good calibration leaves of the time offset
constexpr double kPriorFactor = 10.0;
constexpr double kPlacePriorFactor = 3.0;
constexpr double kMillimetres = 1e3;
constexpr double kMilliseconds = 1e3;
constexpr double kDegrees = 180.0 / std::numbers::pi;

CameraIntrinsics corrected_lens(const CameraIntrinsics& k, const RigVector& correction, int camera) {
    return corrected(k, correction.segment<kBatchLensDim>(kBatchLens[static_cast<std::size_t>(camera)]));
}

/// The coefficients' names, by model.
std::array<const char*, 4> coefficient_names(Distortion distortion) {
    switch (distortion) {
        case Distortion::kEquidistant: return {"k1", "k2", "k3", "k4"};
        case Distortion::kDoubleSphere: return {"xi", "alpha", "-", "-"};
        case Distortion::kEucm: return {"alpha", "beta", "-", "-"};
        case Distortion::kFov: return {"w", "-", "-", "-"};
        default: return {"k1", "k2", "p1", "p2"};
    }
}

/// Fills name, unit and advice of one entry of a lens, and its values.
RigParameter lens_parameter(int camera, int i, const CameraIntrinsics& given, const CameraIntrinsics& refined) {
    const auto row = [&](const char* name, const char* unit, double a, double b, const char* advice) {
        RigParameter p;
        p.name = fmt::format("cam{}.{}", camera, name);
        p.unit = unit;
        p.given = a;
        p.refined = b;
        p.advice = advice;
        return p;
    };
    constexpr const char* kFocal = "fly past near things, in all directions";
    constexpr const char* kPrincipal = "fly more yaw, pitch and roll";
    switch (i) {
        case 0: return row("fx", "px", given.fx, refined.fx, kFocal);
        case 1: return row("fy", "px", given.fy, refined.fy, kFocal);
        case 2: return row("cx", "px", given.cx, refined.cx, kPrincipal);
        case 3: return row("cy", "px", given.cy, refined.cy, kPrincipal);
        default: break;
    }
    const auto k = static_cast<std::size_t>(i - 4);
    return row(coefficient_names(given.distortion)[k], "-", given.coeffs[k], refined.coeffs[k],
               "let things pass through the corners of the images");
}

RigParameter mount_parameter(int camera, int i, const Se3& given, const RigVector& correction) {
    constexpr std::array<char, 3> kAxes{'x', 'y', 'z'};
    const double d = correction(kBatchMount[static_cast<std::size_t>(camera)] + i);
    const char axis = kAxes[static_cast<std::size_t>(i % 3)];
    RigParameter p;
    if (i < 3) {
        p.name = fmt::format("cam{}.turn_{}", camera, axis);
        p.unit = "deg";
        p.refined = d * kDegrees;
        p.advice = "fly more yaw, pitch and roll";
    } else {
        p.name = fmt::format("cam{}.place_{}", camera, axis);
        p.unit = "mm";
        p.given = given.p(i - 3) * kMillimetres;
        p.refined = p.given + d * kMillimetres;
        p.advice = "turn faster about all axes, with near things in view";
    }
    return p;
}

/// Factor from an entry of the vector to the unit of its parameter.
double unit_of(int entry, const StereoRig& rig) {
    if (entry == kBatchTime) {
        return kMilliseconds;
    }
    if (entry >= kBatchMount[0]) {
        return (entry - kBatchMount[0]) % kBatchMountDim < 3 ? kDegrees : kMillimetres;
    }
    const CameraIntrinsics& k = (entry < kBatchLens[1] ? rig.left : rig.right).intrinsics();
    const int i = entry % kBatchLensDim;
    return i == 0 ? k.fx : (i == 1 ? k.fy : 1.0);
}

}  // namespace

Status apply_correction(const RigAndTime& given, const RigVector& correction, RigAndTime& out) {
    const CameraIntrinsics left = corrected_lens(given.rig.left.intrinsics(), correction, 0);
    const CameraIntrinsics right = corrected_lens(given.rig.right.intrinsics(), correction, 1);
    FACET_TRY(CameraModel::validate(left));
    FACET_TRY(CameraModel::validate(right));
    RigAndTime refined;
    refined.rig = {CameraModel(left), CameraModel(right),
                   given.rig.T_B_C0.box_plus(correction.segment<kBatchMountDim>(kBatchMount[0])),
                   given.rig.T_B_C1.box_plus(correction.segment<kBatchMountDim>(kBatchMount[1]))};
    refined.time_shift_s = given.time_shift_s + correction(kBatchTime);
    out = refined;
    return Status::kOk;
}

RigVector good_sigmas(const StereoRig& rig) {
    const CalibrationSigmas good;
    RigVector sigma = RigVector::Zero();
    for (std::size_t camera = 0; camera < 2; ++camera) {
        const Distortion distortion = (camera == 0 ? rig.left : rig.right).intrinsics().distortion;
        auto lens = sigma.segment<kBatchLensDim>(kBatchLens[camera]);
        lens << good.focal, good.focal, good.principal_px, good.principal_px, good.radial, good.radial, 0.0, 0.0;
        const bool is_radial = distortion == Distortion::kEquidistant;
        lens.tail<2>().setConstant(is_radial ? good.radial : good.tangential);
        for (int i = 0; i < 4; ++i) {
            lens(4 + i) *= i < coefficient_count(distortion) ? 1.0 : 0.0;
        }
        sigma.segment<3>(kBatchMount[camera]).setConstant(good.rotation_rad);
        sigma.segment<3>(kBatchMount[camera] + 3).setConstant(good.place_m);
    }
    sigma(kBatchTime) = kTimeSigmaS;
    return sigma;
}

RigVector prior_sigmas(const StereoRig& rig, double scale) {
    RigVector sigma = scale * kPriorFactor * good_sigmas(rig);
    for (const int mount : kBatchMount) {
        sigma.segment<3>(mount + 3) *= kPlacePriorFactor / kPriorFactor;
    }
    return sigma;
}

ParameterVerdict judge_parameter(double sigma, double prior_sigma, double good_sigma) {
    if (sigma > kUnseenShare * prior_sigma) {
        return ParameterVerdict::kNotObservable;
    }
    return sigma <= good_sigma ? ParameterVerdict::kFound : ParameterVerdict::kWeak;
}

std::vector<RigParameter> describe_parameters(const RigAndTime& given, const RigVector& correction,
                                              const RigVector& sigma, const RigVector& prior) {
    const RigVector good = good_sigmas(given.rig);
    std::vector<RigParameter> parameters;
    for (int entry = 0; entry < kBatchDim; ++entry) {
        if (prior(entry) == 0.0) {
            continue;
        }
        RigParameter p;
        if (entry < kBatchMount[0]) {
            const int camera = entry / kBatchLensDim;
            const CameraIntrinsics& k = (camera == 0 ? given.rig.left : given.rig.right).intrinsics();
            p = lens_parameter(camera, entry % kBatchLensDim, k, corrected_lens(k, correction, camera));
        } else if (entry < kBatchTime) {
            const int camera = (entry - kBatchMount[0]) / kBatchMountDim;
            p = mount_parameter(camera, (entry - kBatchMount[0]) % kBatchMountDim,
                                camera == 0 ? given.rig.T_B_C0 : given.rig.T_B_C1, correction);
        } else {
            p.name = "time_shift";
            p.unit = "ms";
            p.given = given.time_shift_s * kMilliseconds;
            p.refined = p.given + correction(entry) * kMilliseconds;
            p.advice = "turn faster";
        }
        const double unit = unit_of(entry, given.rig);
        p.sigma = unit * sigma(entry);
        p.prior_sigma = unit * prior(entry);
        p.verdict = judge_parameter(sigma(entry), prior(entry), good(entry));
        parameters.push_back(p);
    }
    return parameters;
}

const char* to_string(ParameterVerdict verdict) {
    switch (verdict) {
        case ParameterVerdict::kFound: return "found";
        case ParameterVerdict::kWeak: return "weak";
        case ParameterVerdict::kNotObservable: break;
    }
    return "not observable: kept as given";
}

}  // namespace facet
