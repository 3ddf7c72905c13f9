// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/outlier_test.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "estimator/frontend/simd.h"
#include "estimator/geometry/stereo_precision.h"
#include "platform/base/assert.h"

namespace facet {
namespace {

// Largest error of an inlier in the two-point outlier test (px).
constexpr double kRansacThreshold_px = 1.5;
constexpr std::size_t kMinMonoPairs = 8;
constexpr std::size_t kMinStereoPairs = 4;
constexpr double kMinParallaxPx = 1.5;   // median; below, epipolar lines are noise
constexpr double kRotationSigma = 2e-3;  // rad; gyroscope over one keyframe interval, bias error included
constexpr double kPointSigmaPx = 0.5;    // of one stereo observation
constexpr double kChiSquared3 = 11.34;   // 99 % of chi^2 with 3 degrees of freedom
constexpr int kRefineSteps = 4;

constexpr double kMinLine = 1e-12;  // change of the epipolar residual per pixel; below, the line is unknown

/// Signed distance of xy to the epipolar line of the bearing f (px), to first order in the image:
///   e = t x f . [xy; 1],  distance = e / |de / duv|
double epipolar_distance(const MonoPair& pair, const Eigen::Matrix2d& d_xy_d_uv, const Eigen::Vector3d& t,
                         const Eigen::Vector3d& f) {
    const Eigen::Vector3d line = t.cross(f);
    const double norm = (d_xy_d_uv.transpose() * line.head<2>()).norm();
    return norm > kMinLine ? line.dot(pair.xy.homogeneous()) / norm : 0.0;
}

}  // namespace

void OutlierTest::configure(const FrontendConfig& config, const StereoRig& rig) {
    config_ = config;
    rig_ = rig;
    T_C1_C0_ = rig.T_C1_C0();
}

std::uint32_t OutlierTest::draw(std::uint32_t below) {
    random_ = random_ * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<std::uint32_t>(((random_ >> 32U) * below) >> 32U);
}

void OutlierTest::prepare_mono(std::span<const MonoPair> pairs) {
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        const Eigen::Matrix2d d_uv_d_xy = rig_.left.d_uv_d_xy(pairs[i].xy);
        normals_[i] = pairs[i].rotated.cross(pairs[i].xy.homogeneous());
        parallax_[i] = (d_uv_d_xy * (pairs[i].rotated.hnormalized() - pairs[i].xy)).norm();
        d_xy_d_uv_[i] = d_uv_d_xy.inverse();
        rays_.x[i] = static_cast<float>(pairs[i].xy.x());
        rays_.y[i] = static_cast<float>(pairs[i].xy.y());
        rays_.xu[i] = static_cast<float>(d_xy_d_uv_[i](0, 0));
        rays_.xv[i] = static_cast<float>(d_xy_d_uv_[i](0, 1));
        rays_.yu[i] = static_cast<float>(d_xy_d_uv_[i](1, 0));
        rays_.yv[i] = static_cast<float>(d_xy_d_uv_[i](1, 1));
    }
}

void OutlierTest::load_mono(std::span<const MonoPair> pairs, const Eigen::Vector3d& theta) {
    static_assert(kMaxFeatures % simd::kLanes == 0);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        const Eigen::Vector3f f = (pairs[i].rotated + theta.cross(pairs[i].rotated)).cast<float>();
        rays_.fx[i] = f.x();
        rays_.fy[i] = f.y();
        rays_.fz[i] = f.z();
    }
    rays_used_ = pairs.size();
    for (; rays_used_ % simd::kLanes != 0; ++rays_used_) {
        rays_.fx[rays_used_] = rays_.fy[rays_used_] = rays_.fz[rays_used_] = 0.0F;
    }
}

double OutlierTest::score_mono(const Eigen::Vector3d& direction) const {
    using simd::Floats;
    const Eigen::Vector3f t = direction.cast<float>();
    const auto limit = static_cast<float>(kRansacThreshold_px);
    const float inverse_limit2 = 1.0F / (limit * limit);
    constexpr auto kLeast2 = static_cast<float>(kMinLine * kMinLine);
    Floats score{};
    for (std::size_t i = 0; i < rays_used_; i += simd::kLanes) {
        const Floats fx = simd::load(&rays_.fx[i]);
        const Floats fy = simd::load(&rays_.fy[i]);
        const Floats fz = simd::load(&rays_.fz[i]);
        // The epipolar line t x f, and its distance from x: see epipolar_distance().
        const Floats lx = t.y() * fz - t.z() * fy;
        const Floats ly = t.z() * fx - t.x() * fz;
        const Floats lz = t.x() * fy - t.y() * fx;
        const Floats e = lx * simd::load(&rays_.x[i]) + ly * simd::load(&rays_.y[i]) + lz;
        const Floats du = lx * simd::load(&rays_.xu[i]) + ly * simd::load(&rays_.yu[i]);
        const Floats dv = lx * simd::load(&rays_.xv[i]) + ly * simd::load(&rays_.yv[i]);
        const Floats norm2 = du * du + dv * dv;
        const Floats gone = e * e * inverse_limit2 / (norm2 > kLeast2 ? norm2 : simd::splat(kLeast2));
        score += 1.0F - (gone < 1.0F ? gone : simd::splat(1.0F));
    }
    return static_cast<double>(simd::sum(score));
}

void OutlierTest::refine_mono(std::span<const MonoPair> pairs, Eigen::Vector3d& t, Eigen::Vector3d& theta) const {
    // Gauss-Newton on 5 parameters: theta and t along two directions normal to it. Residual e = t . (f x x) / |line|,
    // f = f' + theta x f'. Weights: truncated quadratic of Tukey's shape; prior on theta.
    const double limit = 2.0 * kRansacThreshold_px;
    for (int step = 0; step < kRefineSteps; ++step) {
        const Eigen::Vector3d b1 = t.unitOrthogonal();
        const Eigen::Vector3d b2 = t.cross(b1);
        Eigen::Matrix<double, 5, 5> h = Eigen::Matrix<double, 5, 5>::Zero();
        Eigen::Matrix<double, 5, 1> g = Eigen::Matrix<double, 5, 1>::Zero();
        for (std::size_t i = 0; i < pairs.size(); ++i) {
            const MonoPair& pair = pairs[i];
            const Eigen::Vector3d x = pair.xy.homogeneous();
            const Eigen::Vector3d f = pair.rotated + theta.cross(pair.rotated);
            const double norm = (d_xy_d_uv_[i].transpose() * t.cross(f).head<2>()).norm();
            if (!(norm > kMinLine)) {
                continue;
            }
            const Eigen::Vector3d n = f.cross(x);
            const double e = t.dot(n) / norm;
            const double ratio = e / limit;
            if (std::abs(ratio) >= 1.0) {
                continue;
            }
            const double w = (1.0 - ratio * ratio) * (1.0 - ratio * ratio) / (kPointSigmaPx * kPointSigmaPx);
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

bool OutlierTest::draw_direction(std::size_t n, Eigen::Vector3d& best_t, double& best_score) {
    random_ = config_.seed;
    best_score = -1.0;
    for (int k = 0; k < FrontendConfig::kRansacIterations; ++k) {
        const std::size_t i = draw(static_cast<std::uint32_t>(n));
        const std::size_t j = draw(static_cast<std::uint32_t>(n));
        const Eigen::Vector3d t = normals_[i].cross(normals_[j]);
        const double norm = t.norm();
        if (i == j || !(norm > 1e-3 * normals_[i].norm() * normals_[j].norm()) || norm < 1e-12) {
            continue;
        }
        const double score = score_mono(t / norm);
        if (score > best_score) {
            best_score = score;
            best_t = t / norm;
        }
    }
    return best_score >= 0.0;
}

Status OutlierTest::mono(std::span<const MonoPair> pairs, std::span<std::uint8_t> inlier) {
    FACET_ASSERT(pairs.size() == inlier.size() && pairs.size() <= normals_.size());
    std::fill(inlier.begin(), inlier.end(), std::uint8_t{1});
    const std::size_t n = pairs.size();
    if (n < kMinMonoPairs) {
        return Status::kDegenerate;
    }
    prepare_mono(pairs);
    const auto middle = parallax_.begin() + static_cast<std::ptrdiff_t>(n / 2);
    std::nth_element(parallax_.begin(), middle, parallax_.begin() + static_cast<std::ptrdiff_t>(n));
    if (!(*middle > kMinParallaxPx)) {
        return Status::kDegenerate;
    }
    load_mono(pairs, Eigen::Vector3d::Zero());
    Eigen::Vector3d best_t;
    double best_score = -1.0;
    if (!draw_direction(n, best_t, best_score)) {
        return Status::kDegenerate;
    }
    Eigen::Vector3d theta = Eigen::Vector3d::Zero();
    Eigen::Vector3d t = best_t;
    refine_mono(pairs, t, theta);
    load_mono(pairs, theta);
    if (score_mono(t) < best_score) {
        t = best_t;
        theta.setZero();
    }
    std::size_t inliers = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const Eigen::Vector3d f = pairs[i].rotated + theta.cross(pairs[i].rotated);
        const double off_px = std::abs(epipolar_distance(pairs[i], d_xy_d_uv_[i], t, f));
        inlier[i] = off_px < kRansacThreshold_px ? 1 : 0;
        inliers += inlier[i];
    }
    if (2 * inliers < n) {
        std::fill(inlier.begin(), inlier.end(), std::uint8_t{1});
        return Status::kDegenerate;
    }
    return Status::kOk;
}

Eigen::Matrix3d OutlierTest::covariance(const Eigen::Vector3d& p) const {
    const double turn = kRotationSigma * p.norm();
    return stereo_covariance(rig_, T_C1_C0_, p, kPointSigmaPx) + turn * turn * Eigen::Matrix3d::Identity();
}

void OutlierTest::load_stereo(std::span<const StereoPair> pairs, const Eigen::Matrix3d& R) {
    Translations& to = translations_;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        const Eigen::Vector3d t = pairs[i].now - R * pairs[i].then;
        const Eigen::Matrix3d c = covariance(pairs[i].now) + R * covariance(pairs[i].then) * R.transpose();
        normals_[i] = t;
        covariances_[i] = c;
        to.x[i] = t.x();
        to.y[i] = t.y();
        to.z[i] = t.z();
        to.xx[i] = c(0, 0);
        to.xy[i] = c(0, 1);
        to.xz[i] = c(0, 2);
        to.yy[i] = c(1, 1);
        to.yz[i] = c(1, 2);
        to.zz[i] = c(2, 2);
    }
}

void OutlierTest::measure_stereo(std::size_t n, const Eigen::Vector3d& t, const Eigen::Matrix3d& c) {
    // d' C^-1 d by the adjugate of the symmetric C.
    const Translations& all = translations_;
    for (std::size_t i = 0; i < n; ++i) {
        const double x = all.x[i] - t.x();
        const double y = all.y[i] - t.y();
        const double z = all.z[i] - t.z();
        const double xx = all.xx[i] + c(0, 0);
        const double xy = all.xy[i] + c(0, 1);
        const double xz = all.xz[i] + c(0, 2);
        const double yy = all.yy[i] + c(1, 1);
        const double yz = all.yz[i] + c(1, 2);
        const double zz = all.zz[i] + c(2, 2);
        const double a = yy * zz - yz * yz;
        const double b = xz * yz - xy * zz;
        const double d = xy * yz - xz * yy;
        const double determinant = xx * a + xy * b + xz * d;
        const double quadratic = a * x * x + (xx * zz - xz * xz) * y * y + (xx * yy - xy * xy) * z * z +
                                 2.0 * (b * x * y + d * x * z + (xy * xz - xx * yz) * y * z);
        distances_[i] = quadratic / determinant;
    }
}

std::size_t OutlierTest::draw_translation(std::size_t n) {
    random_ = config_.seed;
    std::size_t best = n;
    double best_score = -1.0;
    for (int k = 0; k < FrontendConfig::kRansacIterations; ++k) {
        const std::size_t i = draw(static_cast<std::uint32_t>(n));
        measure_stereo(n, normals_[i], covariances_[i]);
        double score = 0.0;
        for (std::size_t j = 0; j < n; ++j) {
            score += std::max(0.0, 1.0 - distances_[j] / kChiSquared3);
        }
        // A far point agrees with everything: so a large covariance lowers the score.
        score /= 1.0 + std::sqrt(covariances_[i].trace()) / rig_.baseline_m();
        if (score > best_score) {
            best_score = score;
            best = i;
        }
    }
    return best;
}

Status OutlierTest::stereo(std::span<const StereoPair> pairs, const Eigen::Matrix3d& R,
                           std::span<std::uint8_t> inlier) {
    FACET_ASSERT(pairs.size() == inlier.size() && pairs.size() <= normals_.size());
    std::fill(inlier.begin(), inlier.end(), std::uint8_t{1});
    const std::size_t n = pairs.size();
    if (n < kMinStereoPairs) {
        return Status::kDegenerate;
    }
    load_stereo(pairs, R);
    const std::size_t best = draw_translation(n);
    Eigen::Vector3d t = normals_[best];
    Eigen::Matrix3d cov = covariances_[best];
    for (int step = 0; step < 2; ++step) {
        Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
        Eigen::Vector3d weighted = Eigen::Vector3d::Zero();
        measure_stereo(n, t, cov);
        for (std::size_t j = 0; j < n; ++j) {
            if (distances_[j] < kChiSquared3) {
                const Eigen::Matrix3d w = covariances_[j].inverse();
                information += w;
                weighted += w * normals_[j];
            }
        }
        cov = information.inverse();
        t = cov * weighted;
    }
    std::size_t inliers = 0;
    measure_stereo(n, t, cov);
    for (std::size_t j = 0; j < n; ++j) {
        inlier[j] = distances_[j] < kChiSquared3 ? 1 : 0;
        inliers += inlier[j];
    }
    if (2 * inliers < n) {
        std::fill(inlier.begin(), inlier.end(), std::uint8_t{1});
        return Status::kDegenerate;
    }
    return Status::kOk;
}

}  // namespace facet
