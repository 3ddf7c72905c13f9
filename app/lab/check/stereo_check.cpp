// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/check/stereo_check.h"

#include <fmt/core.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "app/lab/faults/calibration_error.h"
#include "app/support/statistics.h"
#include "estimator/geometry/so3.h"

namespace facet {
namespace {

constexpr double kMatchNoisePx = 0.15;
constexpr int kDraws = 16;
constexpr std::size_t kMinPairs = 40;
constexpr double kMostlyInFront = 0.8;
constexpr double kMuchBetter = 1.0 / 3.0;
constexpr double kDarkGrey = 8.0;  // grey levels: nothing can be seen
constexpr double kSameGrey = 0.5;  // grey levels: less than the noise of any camera

/// A pair as bearings, with their derivatives by the pixels.
struct BearingPair {
    Eigen::Vector3d f0;
    Eigen::Vector3d f1;
    Eigen::Matrix2d d_f0;
    Eigen::Matrix2d d_f1;
};

bool bearings_of(const StereoRig& rig, const PointPair& pair, BearingPair& out) {
    Eigen::Vector2d x0;
    Eigen::Vector2d x1;
    if (!ok(rig.left.unproject(pair.first, x0, &out.d_f0)) || !ok(rig.right.unproject(pair.second, x1, &out.d_f1))) {
        return false;
    }
    out.f0 = x0.homogeneous();
    out.f1 = x1.homogeneous();
    return true;
}

/// Whether the point nearest to both lines of sight lies in front of both cameras: R f0 z0 + t = f1 z1.
bool is_in_front_of_both(const Se3& T_C1_C0, const BearingPair& b) {
    Eigen::Matrix<double, 3, 2> a;
    a << T_C1_C0.q * b.f0, -b.f1;
    const Eigen::Vector2d z = (a.transpose() * a).inverse() * (a.transpose() * -T_C1_C0.p);
    return z.x() > 0.0 && z.y() > 0.0;
}

StereoRig exchanged(const StereoRig& rig, bool lenses, bool poses) {
    StereoRig out = rig;
    if (lenses) {
        std::swap(out.left, out.right);
    }
    if (poses) {
        std::swap(out.T_B_C0, out.T_B_C1);
    }
    return out;
}

/// A way in which calibrations are confused.
struct Confusion {
    const char* sentence;
    StereoRig rig;
};

std::array<Confusion, 4> confusions(const StereoRig& rig) {
    return {{{"the images of cam0 and cam1, or their calibrations, are exchanged.", exchanged(rig, true, true)},
             {"the intrinsics of cam0 and cam1 are exchanged.", exchanged(rig, true, false)},
             {"the poses of cam0 and cam1 on the body are exchanged.", exchanged(rig, false, true)},
             {"the cameras' poses are inverted: T_BS maps camera to body, T_cam_imu maps IMU to camera.",
              {rig.left, rig.right, rig.T_B_C0.inverse(), rig.T_B_C1.inverse()}}}};
}

/// Small is good: points behind the cameras count as badly as a large distance.
double badness(const EpipolarFit& fit) { return fit.median_px + (fit.in_front > kMostlyInFront ? 0.0 : 10.0); }

CheckVerdict judge_order(const StereoRig& rig, std::span<const PointPair> pairs, const EpipolarFit& given,
                         double expected_px) {
    CheckVerdict verdict{.name = "camera order",
                         .level = CheckLevel::kOk,
                         .sentence = "left and right are where the calibration says.",
                         .figures = {{"in_front", given.in_front}}};
    const Confusion* best = nullptr;
    double least = badness(given);
    const std::array<Confusion, 4> others = confusions(rig);
    for (const Confusion& other : others) {
        const EpipolarFit fit = fit_epipolar(other.rig, pairs);
        const double bad = badness(fit);
        if (fit.points >= kMinPairs && bad < least && bad < kMuchBetter * badness(given) && bad < 6.0 * expected_px) {
            best = &other;
            least = bad;
        }
    }
    if (best != nullptr && badness(given) > 2.0 * expected_px) {
        verdict.level = CheckLevel::kWrong;
        verdict.sentence = best->sentence;
    } else if (given.in_front <= kMostlyInFront) {
        verdict.level = CheckLevel::kWrong;
        verdict.sentence =
            fmt::format("only {:.0f} % of the points lie in front of both cameras.", 100.0 * given.in_front);
    }
    return verdict;
}

}  // namespace

std::vector<double> epipolar_distances(const StereoRig& rig, std::span<const PointPair> pairs) {
    const Se3 T_C1_C0 = rig.T_C1_C0();
    const Eigen::Matrix3d essential = skew(T_C1_C0.p.normalized()) * T_C1_C0.R();
    std::vector<double> distances;
    for (const PointPair& pair : pairs) {
        BearingPair b;
        if (bearings_of(rig, pair, b)) {
            const Eigen::Vector2d g0 = b.d_f0.transpose() * (essential.transpose() * b.f1).head<2>();
            const Eigen::Vector2d g1 = b.d_f1.transpose() * (essential * b.f0).head<2>();
            const double gradient = std::sqrt(g0.squaredNorm() + g1.squaredNorm());
            distances.push_back(b.f1.dot(essential * b.f0) / gradient);
        }
    }
    return distances;
}

EpipolarFit fit_epipolar(const StereoRig& rig, std::span<const PointPair> pairs) {
    std::vector<double> distances = epipolar_distances(rig, pairs);
    std::ranges::for_each(distances, [](double& d) { d = std::abs(d); });
    const OrderStatistics statistics(std::move(distances));
    EpipolarFit fit{statistics.median(), statistics.quantile(0.95), 0.0, statistics.count()};
    const Se3 T_C1_C0 = rig.T_C1_C0();
    for (const PointPair& pair : pairs) {
        BearingPair b;
        const bool counts = bearings_of(rig, pair, b) && is_in_front_of_both(T_C1_C0, b);
        fit.in_front += counts ? 1.0 / static_cast<double>(fit.points) : 0.0;
    }
    return fit;
}

double expected_epipolar_px(const StereoRig& rig, std::span<const PointPair> pairs) {
    const std::vector<double> given = epipolar_distances(rig, pairs);
    double squares = 0.0;
    int draws = 0;
    for (std::uint64_t seed = 1; seed <= kDraws; ++seed) {
        StereoRig drawn = rig;
        if (!add_calibration_error(1.0, seed, drawn)) {
            continue;
        }
        const std::vector<double> moved = epipolar_distances(drawn, pairs);
        std::vector<double> shift;
        for (std::size_t i = 0; i < std::min(given.size(), moved.size()); ++i) {
            shift.push_back(std::abs(moved[i] - given[i]));
        }
        const double median = OrderStatistics(std::move(shift)).median();
        squares += median * median;
        ++draws;
    }
    return std::sqrt(kMatchNoisePx * kMatchNoisePx + squares / std::max(draws, 1));
}

std::vector<CheckVerdict> check_stereo(const StereoRig& rig, std::span<const PointPair> pairs) {
    const EpipolarFit fit = fit_epipolar(rig, pairs);
    CheckVerdict error{.name = "stereo epipolar error",
                       .sentence = fmt::format("only {} points were found in both images.", pairs.size()),
                       .figures = {{"points", static_cast<double>(pairs.size())}}};
    if (fit.points < kMinPairs) {
        return {error};
    }
    const double expected_px = expected_epipolar_px(rig, pairs);
    error.level = level_of(fit.median_px, 2.0 * expected_px, 6.0 * expected_px);
    error.sentence = fmt::format(
        "{} points lie {:.2f} px from their epipolar lines in the median, 95 % within {:.2f} px; a good calibration "
        "leaves about {:.2f} px.",
        fit.points, fit.median_px, fit.q95_px, expected_px);
    error.figures = {{"points", static_cast<double>(fit.points)},
                     {"median_px", fit.median_px},
                     {"q95_px", fit.q95_px},
                     {"expected_px", expected_px}};
    return {error, judge_order(rig, pairs, fit, expected_px)};
}

CheckVerdict check_same_image(std::span<const double> differences, double brightest_mean) {
    CheckVerdict verdict{.name = "two images", .sentence = "there is no stereo pair.", .figures = {}};
    if (differences.empty()) {
        return verdict;
    }
    const double median = OrderStatistics({differences.begin(), differences.end()}).median();
    verdict.figures = {{"mean_difference_grey", median}};
    verdict.level = median < kSameGrey ? CheckLevel::kWrong : CheckLevel::kOk;
    verdict.sentence = median < kSameGrey ? "both cameras show the same image: one camera was recorded twice."
                                          : "the cameras show different images.";
    if (median < kSameGrey && brightest_mean < kDarkGrey) {
        verdict.figures.emplace_back("brightest_mean_grey", brightest_mean);
        verdict.sentence = fmt::format(
            "the images are too dark to be compared: their mean is {:.1f} of 255 (facet convert --bits if they were 10 "
            "or 12 bits in 16).",
            brightest_mean);
    }
    return verdict;
}

}  // namespace facet
