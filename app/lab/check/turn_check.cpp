// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/check/turn_check.h"

#include <fmt/core.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "app/support/statistics.h"
#include "estimator/geometry/so3.h"
#include "platform/base/angle.h"

namespace facet {
namespace {

constexpr std::size_t kMinTurns = 20;
constexpr double kLeastRate = 0.1;  // rad/s rms
constexpr double kLeastAgreement = 0.75;
constexpr double kClearLead = 2.0;  // ratio of squared residuals between two arrangements
constexpr double kReachS = 0.15;
constexpr double kStepS = 0.005;
constexpr double kFineOffsetS = 0.005;
constexpr double kWrongOffsetS = 0.02;
constexpr double kLeastOffDeg = 3.0;
constexpr double kFarAbove = 12.0;

/// Rates of camera and gyroscope over the same intervals, each less its mean.
struct RatePairs {
    Eigen::Matrix3Xd camera;
    Eigen::Matrix3Xd gyro;
};

/// Attitude by integration of the gyroscope, sample by sample.
class GyroTrack {
public:
    /// @param unit  of the readings (rad/s)
    GyroTrack(std::span<const ImuSample> samples, double unit) : samples_(samples), unit_(unit) {
        Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
        attitude_.push_back(q);
        for (std::size_t i = 1; i < samples.size(); ++i) {
            const double dt = (samples[i].stamp - samples[i - 1].stamp).seconds();
            q = (q * so3_exp(0.5 * dt * unit * (samples[i].w_B + samples[i - 1].w_B))).normalized();
            attitude_.push_back(q);
        }
    }

    /// @return false if t is not between the first and the last sample
    bool at(Timestamp t, Eigen::Quaterniond& q) const {
        const auto after = std::ranges::upper_bound(samples_, t, {}, &ImuSample::stamp);
        if (after == samples_.begin() || after == samples_.end()) {
            return false;
        }
        const auto i = static_cast<std::size_t>(after - samples_.begin()) - 1;
        q = attitude_[i] * so3_exp((t - samples_[i].stamp).seconds() * unit_ * samples_[i].w_B);
        return true;
    }

private:
    std::span<const ImuSample> samples_;
    double unit_;
    std::vector<Eigen::Quaterniond> attitude_;
};

RatePairs pair_rates(std::span<const CameraTurn> turns, const GyroTrack& gyro, double shift_s) {
    RatePairs pairs;
    pairs.camera.resize(3, static_cast<Eigen::Index>(turns.size()));
    pairs.gyro.resize(3, static_cast<Eigen::Index>(turns.size()));
    Eigen::Index count = 0;
    const Duration shift = Duration::from_seconds(shift_s);
    for (const CameraTurn& turn : turns) {
        Eigen::Quaterniond q0;
        Eigen::Quaterniond q1;
        if (gyro.at(turn.from + shift, q0) && gyro.at(turn.to + shift, q1)) {
            const double dt = (turn.to - turn.from).seconds();
            pairs.camera.col(count) = turn.theta_C / dt;
            pairs.gyro.col(count++) = so3_log(q0.conjugate() * q1) / dt;
        }
    }
    pairs.camera.conservativeResize(3, count);
    pairs.gyro.conservativeResize(3, count);
    if (count > 0) {
        const Eigen::Vector3d camera_mean = pairs.camera.rowwise().mean();
        const Eigen::Vector3d gyro_mean = pairs.gyro.rowwise().mean();
        pairs.camera.colwise() -= camera_mean;
        pairs.gyro.colwise() -= gyro_mean;
    }
    return pairs;
}

double norm_product(const RatePairs& p) { return std::max(p.gyro.norm() * p.camera.norm(), 1e-12); }

/// Correlation of the rates under a map of the camera's axes to the gyroscope's, 1 if they are proportional.
double agreement(const RatePairs& p, const Eigen::Matrix3d& map) {
    return (p.gyro.array() * (map * p.camera).array()).sum() / norm_product(p);
}

/// The same under the best orthogonal map, reflections included.
double best_agreement(const RatePairs& p) {
    const Eigen::Matrix3d h = p.gyro * p.camera.transpose();
    return Eigen::JacobiSVD<Eigen::MatrixXd>(h).singularValues().sum() / norm_product(p);
}

/// Squared residual of the camera's rates as a multiple of the gyroscope's, turned by a map: a share of their square.
double misfit(const RatePairs& p, const Eigen::Matrix3d& map) {
    const double a = std::max(agreement(p, map), 0.0);
    return 1.0 - a * a;
}

/// The orthogonal map of the camera's rates that fits the gyroscope's best.
Eigen::Matrix3d best_map(const RatePairs& p, bool is_rotation) {
    return nearest_orthogonal(p.gyro * p.camera.transpose(), is_rotation);
}

/// All matrices with one +1 or -1 in each row and column, the identity first.
std::vector<Eigen::Matrix3d> signed_permutations() {
    std::vector<Eigen::Matrix3d> all;
    std::array<int, 3> order{0, 1, 2};
    do {
        for (int signs = 0; signs < 8; ++signs) {
            Eigen::Matrix3d p = Eigen::Matrix3d::Zero();
            for (int row = 0; row < 3; ++row) {
                p(row, order[static_cast<std::size_t>(row)]) = (signs >> row & 1) != 0 ? -1.0 : 1.0;
            }
            all.push_back(p);
        }
    } while (std::ranges::next_permutation(order).found);
    return all;
}

/// "x y z" of the readings in terms of the true axes, such as "y -x z".
std::string name_of(const Eigen::Matrix3d& permutation) {
    std::string text;
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) {
            if (permutation(row, column) != 0.0) {
                text +=
                    fmt::format("{}{}{}", row > 0 ? " " : "", permutation(row, column) < 0.0 ? "-" : "", "xyz"[column]);
            }
        }
    }
    return text;
}

CheckVerdict judge_axes(const RatePairs& p, const Eigen::Matrix3d& R_B_C) {
    CheckVerdict verdict{.name = "imu axes", .sentence = {}, .figures = {}};
    const double given = misfit(p, R_B_C);
    double least = 1.0;  // of the others
    Eigen::Matrix3d best = Eigen::Matrix3d::Identity();
    for (const Eigen::Matrix3d& permutation : signed_permutations()) {
        const double other = misfit(p, permutation * R_B_C);
        if (!permutation.isIdentity() && other < least) {
            least = other;
            best = permutation;
        }
    }
    const double off_deg =
        Eigen::AngleAxisd(Eigen::Matrix3d(best_map(p, true) * R_B_C.transpose())).angle() / kRadPerDeg;
    verdict.figures = {{"misfit", given}, {"least_misfit_of_others", least}, {"rotation_off_deg", off_deg}};
    const double inverse = misfit(p, R_B_C.transpose());
    if (inverse * kClearLead < given && inverse < kClearLead * least) {
        verdict.level = CheckLevel::kWrong;
        verdict.sentence = "the camera's rotation is inverted: T_BS maps camera to body, T_cam_imu maps IMU to camera.";
    } else if (least * kClearLead < given) {
        verdict.level = CheckLevel::kWrong;
        verdict.sentence =
            fmt::format("the gyroscope's x y z are {} of the frame that the calibration means.", name_of(best));
    } else if (given * kClearLead > least) {
        verdict.sentence = "the vehicle turns too little about some axis: those could be mixed up.";
    } else {
        verdict.level = off_deg > kLeastOffDeg ? CheckLevel::kSuspicious : CheckLevel::kOk;
        verdict.sentence = fmt::format(
            "images and gyroscope turn alike; the rotation seen is {:.1f} deg from the given one.", off_deg);
    }
    return verdict;
}

/// The gyroscope's noise is small beside the images', so these are fitted by it.
/// @param unit  by which the readings were multiplied
CheckVerdict judge_units(const RatePairs& p, double unit) {
    const double ratio = p.gyro.norm() / (best_agreement(p) * p.camera.norm() * unit);
    CheckVerdict verdict{.name = "gyroscope units",
                         .level = level_of(std::abs(ratio - 1.0), 0.1, 0.3),
                         .sentence = fmt::format("the gyroscope shows {:.2f} times the rates of the images.", ratio),
                         .figures = {{"ratio", ratio}}};
    if (std::abs(ratio * kRadPerDeg - 1.0) < 0.3) {
        verdict.sentence = fmt::format(
            "the gyroscope shows {:.0f} times the rates of the images: it is in degrees per second.", ratio);
    }
    return verdict;
}

/// Degrees if the readings are far above the images' rates, rms_camera: integrated as radians they would wrap.
double unit_of_readings(std::span<const ImuSample> samples, double rms_camera) {
    double squares = 0.0;
    for (const ImuSample& s : samples) {
        squares += s.w_B.squaredNorm() / static_cast<double>(samples.size());
    }
    return std::sqrt(squares) > kFarAbove * rms_camera ? kRadPerDeg : 1.0;
}

/// Where rates agree best.
struct Shift {
    double s = 0.0;
    double sigma_s = 0.0;  ///< from the bend of the likelihood, residuals taken as normal and independent
    double agreement = 0.0;
};

CheckVerdict judge_offset(const Shift& shift) {
    const double at_least_s = std::max(0.0, std::abs(shift.s) - 2.0 * shift.sigma_s);
    CheckVerdict verdict{.name = "time offset",
                         .level = level_of(at_least_s, kFineOffsetS, kWrongOffsetS),
                         .sentence = fmt::format("image stamps plus {:.1f} +- {:.1f} ms agree best with the IMU's "
                                                 "(beyond the shift that the calibration has).",
                                                 1e3 * shift.s, 1e3 * shift.sigma_s),
                         .figures = {{"offset_s", shift.s}, {"sigma_s", shift.sigma_s}}};
    if (verdict.level == CheckLevel::kOk && 2.0 * shift.sigma_s > kWrongOffsetS) {
        verdict.level = CheckLevel::kCannotTell;
    }
    return verdict;
}

/// The three, without knowledge.
std::vector<CheckVerdict> unknown(const std::string& why) {
    std::vector<CheckVerdict> verdicts;
    for (const char* name : {"imu axes", "gyroscope units", "time offset"}) {
        verdicts.push_back({.name = name, .sentence = why, .figures = {}});
    }
    return verdicts;
}

/// Misfit under the best map at a shift.
double misfit_at(std::span<const CameraTurn> turns, const GyroTrack& gyro, double shift_s) {
    const RatePairs p = pair_rates(turns, gyro, shift_s);
    const double a = p.camera.cols() > 3 ? best_agreement(p) : 0.0;
    return 1.0 - a * a;
}

/// The shift at which rates agree best, refined by a parabola through its neighbours: near its least value m the misfit
/// is m + 1/2 m'' (shift - s)^2, and -2 log likelihood = 3 N log(misfit) bends by 3 N m'' / m there.
Shift best_shift(std::span<const CameraTurn> turns, const GyroTrack& gyro) {
    const int reach = static_cast<int>(std::lround(kReachS / kStepS));
    std::vector<double> misfits;
    for (int i = -reach; i <= reach; ++i) {
        misfits.push_back(misfit_at(turns, gyro, i * kStepS));
    }
    const auto least = std::clamp(std::ranges::min_element(misfits), misfits.begin() + 1, misfits.end() - 2);
    const double bend = std::max(least[-1] - 2.0 * least[0] + least[1], 1e-9);
    const double fraction = std::clamp(0.5 * (least[-1] - least[1]) / bend, -1.0, 1.0);
    Shift shift;
    shift.s = (static_cast<double>(least - misfits.begin() - reach) + fraction) * kStepS;
    shift.agreement = best_agreement(pair_rates(turns, gyro, shift.s));
    const double misfit = std::max(1.0 - shift.agreement * shift.agreement, 1e-9);
    shift.sigma_s = std::sqrt(2.0 * misfit / (3.0 * static_cast<double>(turns.size()) * bend)) * kStepS;
    return shift;
}

/// The turns that some orthogonal map explains best: a few turns by images are always wrong.
std::vector<CameraTurn> trimmed(std::span<const CameraTurn> turns, const GyroTrack& gyro, double shift_s) {
    const RatePairs p = pair_rates(turns, gyro, shift_s);
    if (p.camera.cols() != static_cast<Eigen::Index>(turns.size())) {
        return {turns.begin(), turns.end()};  // some lie outside the inertial data: keep all
    }
    const double scale = best_agreement(p) * p.gyro.norm() / p.camera.norm();
    const Eigen::RowVectorXd errors = (p.gyro - scale * best_map(p, false) * p.camera).colwise().norm();
    const double limit = OrderStatistics({errors.data(), errors.data() + errors.size()}).quantile(0.9);
    std::vector<CameraTurn> kept;
    for (std::size_t i = 0; i < turns.size(); ++i) {
        if (errors(static_cast<Eigen::Index>(i)) <= limit) {
            kept.push_back(turns[i]);
        }
    }
    return kept;
}

}  // namespace

std::vector<CheckVerdict> check_turns(std::span<const CameraTurn> turns, std::span<const ImuSample> samples,
                                      const Eigen::Matrix3d& R_B_C) {
    if (turns.size() < kMinTurns || samples.size() < 2) {
        return unknown("too few images could be compared with the gyroscope.");
    }
    double squares = 0.0;
    for (const CameraTurn& turn : turns) {
        squares += (turn.theta_C / (turn.to - turn.from).seconds()).squaredNorm();
    }
    const double rms = std::sqrt(squares / static_cast<double>(turns.size()));
    if (rms < kLeastRate) {
        return unknown(fmt::format("the vehicle hardly turns: {:.2f} rad/s rms by the images.", rms));
    }
    const double unit = unit_of_readings(samples, rms);
    const GyroTrack gyro(samples, unit);
    const std::vector<CameraTurn> good = trimmed(turns, gyro, best_shift(turns, gyro).s);
    const Shift shift = best_shift(good, gyro);
    if (shift.agreement < kLeastAgreement) {
        std::vector<CheckVerdict> verdicts = unknown(
            fmt::format("images and gyroscope do not turn alike at any shift within {} s (agreement {:.2f} of 1).",
                        kReachS, shift.agreement));
        verdicts[0].level = CheckLevel::kSuspicious;
        return verdicts;
    }
    const RatePairs pairs = pair_rates(good, gyro, shift.s);
    return {judge_axes(pairs, R_B_C), judge_units(pairs, unit), judge_offset(shift)};
}

}  // namespace facet
