// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/outlier_test.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "estimator/api/capacity.h"
#include "platform/base/assert.h"

namespace facet {
namespace {

constexpr std::size_t kMinMonoPairs = 8;
constexpr std::size_t kMinStereoPairs = 4;
constexpr double kMinParallaxPx = 1.5;   // median; below, epipolar lines are noise
constexpr double kRotationSigma = 2e-3;  // rad; gyroscope over one keyframe interval, bias error included
constexpr double kPointSigmaPx = 0.5;    // of one stereo observation
constexpr double kChiSquared3 = 11.34;   // 99 % of chi^2 with 3 degrees of freedom
constexpr int kRefineSteps = 4;

/// Signed distance of xy to the epipolar line of the bearing f, in normalised units.
double epipolar_distance(const MonoPair& pair, const Eigen::Vector3d& t, const Eigen::Vector3d& f) {
    const Eigen::Vector3d line = t.cross(f);
    const double norm = line.head<2>().norm();
    return norm > 1e-9 ? line.dot(pair.xy.homogeneous()) / norm : 0.0;
}

}  // namespace

void OutlierTest::configure(const FrontendConfig& config, double focal_px, double baseline_m) {
    config_ = config;
    focal_px_ = focal_px;
    baseline_m_ = std::max(baseline_m, 1e-3);
    normals_.assign(kMaxFeatures, Eigen::Vector3d::Zero());
    covariances_.assign(kMaxFeatures, Eigen::Matrix3d::Zero());
    parallax_.assign(kMaxFeatures, 0.0);
}

std::uint32_t OutlierTest::draw(std::uint32_t below) {
    random_ = random_ * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<std::uint32_t>(((random_ >> 32U) * below) >> 32U);
}

double OutlierTest::score_mono(std::span<const MonoPair> pairs, const Eigen::Vector3d& t,
                               const Eigen::Vector3d& theta) const {
    const double limit = config_.ransac_threshold_px / focal_px_;
    double score = 0.0;
    for (const MonoPair& pair : pairs) {
        const double e = epipolar_distance(pair, t, pair.rotated + theta.cross(pair.rotated));
        score += std::max(0.0, 1.0 - e * e / (limit * limit));
    }
    return score;
}

void OutlierTest::refine_mono(std::span<const MonoPair> pairs, Eigen::Vector3d& t, Eigen::Vector3d& theta) const {
    // Gauss-Newton on 5 parameters: theta and t along two directions normal to it. Residual e = t . (f x x) / |line|,
    // f = f' + theta x f'. Weights: truncated quadratic of Tukey's shape; prior on theta.
    const double limit = 2.0 * config_.ransac_threshold_px / focal_px_;
    const double sigma = 0.5 / focal_px_;
    for (int step = 0; step < kRefineSteps; ++step) {
        const Eigen::Vector3d b1 = t.unitOrthogonal();
        const Eigen::Vector3d b2 = t.cross(b1);
        Eigen::Matrix<double, 5, 5> h = Eigen::Matrix<double, 5, 5>::Zero();
        Eigen::Matrix<double, 5, 1> g = Eigen::Matrix<double, 5, 1>::Zero();
        for (const MonoPair& pair : pairs) {
            const Eigen::Vector3d x = pair.xy.homogeneous();
            const Eigen::Vector3d f = pair.rotated + theta.cross(pair.rotated);
            const double norm = t.cross(f).head<2>().norm();
            if (!(norm > 1e-9)) {
                continue;
            }
            const Eigen::Vector3d n = f.cross(x);
            const double e = t.dot(n) / norm;
            const double ratio = e / limit;
            if (std::abs(ratio) >= 1.0) {
                continue;
            }
            const double w = (1.0 - ratio * ratio) * (1.0 - ratio * ratio) / (sigma * sigma);
            Eigen::Matrix<double, 5, 1> j;
            j << pair.rotated.cross(x.cross(t)) / norm, b1.dot(n) / norm, b2.dot(n) / norm;
            h += w * j * j.transpose();
            g += w * e * j;
        }
        h.topLeftCorner<3, 3>().diagonal().array() += 1.0 / (kRotationSigma * kRotationSigma);
        g.head<3>() += theta / (kRotationSigma * kRotationSigma);
        h.diagonal().tail<2>().array() += 1e-9;
        const Eigen::Matrix<double, 5, 1> d = h.ldlt().solve(-g);
        if (!d.allFinite()) {
            return;
        }
        theta += d.head<3>();
        t = (t + d[3] * b1 + d[4] * b2).normalized();
    }
}

Status OutlierTest::mono(std::span<const MonoPair> pairs, std::span<std::uint8_t> inlier) {
    FACET_ASSERT(pairs.size() == inlier.size() && pairs.size() <= normals_.size());
    std::fill(inlier.begin(), inlier.end(), std::uint8_t{1});
    const std::size_t n = pairs.size();
    if (n < kMinMonoPairs) {
        return Status::kDegenerate;
    }
    for (std::size_t i = 0; i < n; ++i) {
        normals_[i] = pairs[i].rotated.cross(pairs[i].xy.homogeneous());
        parallax_[i] = (pairs[i].rotated.hnormalized() - pairs[i].xy).norm() * focal_px_;
    }
    const auto middle = parallax_.begin() + static_cast<std::ptrdiff_t>(n / 2);
    std::nth_element(parallax_.begin(), middle, parallax_.begin() + static_cast<std::ptrdiff_t>(n));
    if (!(*middle > kMinParallaxPx)) {
        return Status::kDegenerate;
    }
    random_ = config_.seed;
    double best_score = -1.0;
    Eigen::Vector3d best_t = Eigen::Vector3d::UnitZ();
    for (int k = 0; k < config_.ransac_iterations; ++k) {
        const std::size_t i = draw(static_cast<std::uint32_t>(n));
        const std::size_t j = draw(static_cast<std::uint32_t>(n));
        const Eigen::Vector3d t = normals_[i].cross(normals_[j]);
        const double norm = t.norm();
        if (i == j || !(norm > 1e-3 * normals_[i].norm() * normals_[j].norm()) || norm < 1e-12) {
            continue;
        }
        const double score = score_mono(pairs, t / norm, Eigen::Vector3d::Zero());
        if (score > best_score) {
            best_score = score;
            best_t = t / norm;
        }
    }
    if (best_score < 0.0) {
        return Status::kDegenerate;
    }
    Eigen::Vector3d theta = Eigen::Vector3d::Zero();
    Eigen::Vector3d t = best_t;
    refine_mono(pairs, t, theta);
    if (score_mono(pairs, t, theta) < best_score) {
        t = best_t;
        theta.setZero();
    }
    std::size_t inliers = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const Eigen::Vector3d f = pairs[i].rotated + theta.cross(pairs[i].rotated);
        inlier[i] = std::abs(epipolar_distance(pairs[i], t, f)) * focal_px_ < config_.ransac_threshold_px ? 1 : 0;
        inliers += inlier[i];
    }
    if (2 * inliers < n) {
        std::fill(inlier.begin(), inlier.end(), std::uint8_t{1});
        return Status::kDegenerate;
    }
    return Status::kOk;
}

Eigen::Matrix3d OutlierTest::covariance(const Eigen::Vector3d& p) const {
    const double z = p.z();
    const double lateral = z * (kPointSigmaPx / focal_px_ + kRotationSigma);
    const double along = z * z * kPointSigmaPx * std::sqrt(2.0) / (focal_px_ * baseline_m_);
    const Eigen::Vector3d ray = p / z;
    return lateral * lateral * Eigen::Matrix3d::Identity() + along * along * ray * ray.transpose();
}

Status OutlierTest::stereo(std::span<const StereoPair> pairs, std::span<std::uint8_t> inlier) {
    FACET_ASSERT(pairs.size() == inlier.size() && pairs.size() <= normals_.size());
    std::fill(inlier.begin(), inlier.end(), std::uint8_t{1});
    const std::size_t n = pairs.size();
    if (n < kMinStereoPairs) {
        return Status::kDegenerate;
    }
    for (std::size_t i = 0; i < n; ++i) {
        normals_[i] = pairs[i].now - pairs[i].rotated;
        covariances_[i] = covariance(pairs[i].now) + covariance(pairs[i].rotated);
    }
    const auto distance = [this](std::size_t i, const Eigen::Vector3d& t, const Eigen::Matrix3d& cov) {
        const Eigen::Vector3d d = normals_[i] - t;
        return d.dot((covariances_[i] + cov).inverse() * d);
    };
    random_ = config_.seed;
    std::size_t best = n;
    double best_score = -1.0;
    for (int k = 0; k < config_.ransac_iterations; ++k) {
        const std::size_t i = draw(static_cast<std::uint32_t>(n));
        double score = 0.0;
        for (std::size_t j = 0; j < n; ++j) {
            score += std::max(0.0, 1.0 - distance(j, normals_[i], covariances_[i]) / kChiSquared3);
        }
        // A far point agrees with everything: its wide covariance is paid for by its volume.
        score /= 1.0 + std::sqrt(covariances_[i].trace()) / baseline_m_;
        if (score > best_score) {
            best_score = score;
            best = i;
        }
    }
    Eigen::Vector3d t = normals_[best];
    Eigen::Matrix3d cov = covariances_[best];
    for (int step = 0; step < 2; ++step) {
        Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
        Eigen::Vector3d weighted = Eigen::Vector3d::Zero();
        for (std::size_t j = 0; j < n; ++j) {
            if (distance(j, t, cov) < kChiSquared3) {
                const Eigen::Matrix3d w = covariances_[j].inverse();
                information += w;
                weighted += w * normals_[j];
            }
        }
        cov = information.inverse();
        t = cov * weighted;
    }
    std::size_t inliers = 0;
    for (std::size_t j = 0; j < n; ++j) {
        inlier[j] = distance(j, t, cov) < kChiSquared3 ? 1 : 0;
        inliers += inlier[j];
    }
    if (2 * inliers < n) {
        std::fill(inlier.begin(), inlier.end(), std::uint8_t{1});
        return Status::kDegenerate;
    }
    return Status::kOk;
}

}  // namespace facet
