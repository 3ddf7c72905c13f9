// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/planes/plane_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace facet {
namespace {

constexpr int kSteps = 3;
constexpr int kBlock = 32;           // points whose weights are computed together
constexpr double kHuber = 1.5;       // sigmas
constexpr double kMinExtent = 0.02;  // m: points nearer to a line than this give no plane
constexpr double kMinRatio = 0.08;   // of the extents: below, the points are nearly collinear
constexpr double kBendChi2 = 16.3;   // 0.1 % quantile of the chi-square of the three quadratic terms

/// Weighted mean and scatter about it.
struct Scatter {
    double weight = 0.0;
    double squared = 0.0;  ///< sum of the whitened residuals' squares
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
};

double variance_across(const PlanePoint& point, const Eigen::Vector3f& n, double surface_sigma) {
    return static_cast<double>(point.variance_along(n)) + surface_sigma * surface_sigma;
}

/// Square roots and quotients of a block of points are taken together, and the sums of a point's weight w and of w p
/// run side by side.
Scatter scatter_of(std::span<const PlanePoint> points, std::span<const std::uint16_t> which, double surface_sigma,
                   const PlaneFit& fit) {
    using Block = Eigen::Array<double, kBlock, 1>;
    const Eigen::Vector3f n = fit.normal_W.cast<float>();
    const Eigen::Vector3d origin = points[which[0]].p_W;  // keeps the sums small far from the world's origin
    Scatter s;
    Eigen::Vector4d sum = Eigen::Vector4d::Zero();
    Eigen::Matrix<double, 4, 3> moment = Eigen::Matrix<double, 4, 3>::Zero();
    Block variance = Block::Ones();
    Block residual = Block::Zero();
    Eigen::Matrix<double, 4, kBlock> from_origin = Eigen::Matrix<double, 4, kBlock>::Ones();
    for (std::size_t begin = 0; begin < which.size(); begin += kBlock) {
        const auto count = static_cast<Eigen::Index>(std::min<std::size_t>(kBlock, which.size() - begin));
        for (Eigen::Index k = 0; k < count; ++k) {
            const PlanePoint& point = points[which[begin + static_cast<std::size_t>(k)]];
            variance[k] = variance_across(point, n, surface_sigma);
            residual[k] = fit.residual(point.p_W);
            from_origin.col(k).head<3>() = point.p_W - origin;
        }
        const Block squared = residual * residual / variance;
        const Block distance = residual.abs() / variance.sqrt();
        const Block weight = kHuber / distance.max(kHuber) / variance;
        for (Eigen::Index k = 0; k < count; ++k) {
            const Eigen::Vector4d weighted = weight[k] * from_origin.col(k);
            sum += weighted;
            s.squared += squared[k];
            for (int axis = 0; axis < 3; ++axis) {
                moment.col(axis) += from_origin(axis, k) * weighted;
            }
        }
    }
    s.weight = sum.w();
    s.mean = sum.head<3>() / s.weight;
    s.scatter = moment.topRows<3>() - s.weight * s.mean * s.mean.transpose();
    s.mean += origin;
    return s;
}

}  // namespace

double bend_of(std::span<const PlanePoint> points, std::span<const std::uint16_t> which, double surface_sigma_m,
               const PlaneFit& fit) {
    using Matrix6 = Eigen::Matrix<double, 6, 6>;
    using Vector6 = Eigen::Matrix<double, 6, 1>;
    Matrix6 h = Matrix6::Zero();
    Vector6 g = Vector6::Zero();
    double weights = 0.0;
    const Eigen::Vector3f n = fit.normal_W.cast<float>();
    for (const std::uint16_t i : which) {
        const Eigen::Vector3d q = points[i].p_W - fit.centroid_W;
        const double u = fit.along_W.dot(q) / fit.extent_along_m;
        const double v = fit.across_W.dot(q) / fit.extent_across_m;
        const double w = 1.0 / variance_across(points[i], n, surface_sigma_m);
        Vector6 j;
        j << 1.0, u, v, u * u, u * v, v * v;
        h += (w * j) * j.transpose();
        g += w * fit.residual(points[i].p_W) * j;
        weights += w;
    }
    h.diagonal().array() += 1e-9 * weights;
    const Vector6 full = h.selfadjointView<Eigen::Lower>().ldlt().solve(g);
    const Eigen::Matrix3d flat = h.topLeftCorner<3, 3>().selfadjointView<Eigen::Lower>();
    const Eigen::Vector3d plane = flat.ldlt().solve(g.head<3>());
    const double explained = full.dot(g) - plane.dot(g.head<3>());  // whitened
    return explained > kBendChi2 * std::max(1.0, fit.chi2) ? std::sqrt(explained / weights) : 0.0;
}

double PlaneFit::sigma_at(const Eigen::Vector3d& p_W) const {
    const Eigen::Vector3d q = p_W - centroid_W;
    const double along = sigma_along_rad * along_W.dot(q);
    const double across = sigma_across_rad * across_W.dot(q);
    return std::sqrt(sigma_m * sigma_m + along * along + across * across);
}

Status describe_plane(std::span<const PlanePoint> points, std::span<const std::uint16_t> which, double surface_sigma_m,
                      PlaneFit& fit, PlaneBend bend) {
    if (which.size() < kMinFitPoints) {
        return Status::kDegenerate;
    }
    PlaneFit out = fit;
    const Scatter s = scatter_of(points, which, surface_sigma_m, fit);
    // The axes of the extent within the plane, whatever way the points lie across it.
    const Eigen::Vector3d a = fit.normal_W.unitOrthogonal();
    const Eigen::Vector3d b = fit.normal_W.cross(a);
    Eigen::Matrix2d flat;
    const double mixed = a.dot(s.scatter * b);
    flat << a.dot(s.scatter * a), mixed, mixed, b.dot(s.scatter * b);
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes;
    axes.computeDirect(flat);
    const double large = axes.eigenvalues()[1];
    const double small = axes.eigenvalues()[0];
    out.extent_along_m = std::sqrt(std::max(0.0, large / s.weight));
    out.extent_across_m = std::sqrt(std::max(0.0, small / s.weight));
    if (!(out.extent_across_m > kMinExtent && out.extent_across_m > kMinRatio * out.extent_along_m)) {
        return Status::kDegenerate;
    }
    const Eigen::Vector2d along = axes.eigenvectors().col(1);
    out.along_W = along.x() * a + along.y() * b;
    out.across_W = fit.normal_W.cross(out.along_W);
    out.centroid_W = s.mean - fit.residual(s.mean) * fit.normal_W;
    out.points = static_cast<int>(which.size());
    out.chi2 = s.squared / (static_cast<double>(which.size()) - 3.0);
    const double scale = std::sqrt(std::max(1.0, out.chi2));
    out.sigma_m = scale / std::sqrt(s.weight);
    out.sigma_along_rad = scale / std::sqrt(large);
    out.sigma_across_rad = scale / std::sqrt(small);
    if (bend == PlaneBend::kAsk) {
        out.bend_m = bend_of(points, which, surface_sigma_m, out);
    }
    fit = out;
    return Status::kOk;
}

Status fit_plane(std::span<const PlanePoint> points, std::span<const std::uint16_t> which, double surface_sigma_m,
                 PlaneFit& fit, PlaneBend bend) {
    if (which.size() < kMinFitPoints) {
        return Status::kDegenerate;
    }
    PlaneFit out = fit;
    for (int step = 0; step < kSteps; ++step) {
        const Scatter s = scatter_of(points, which, surface_sigma_m, out);
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
        eigen.computeDirect(s.scatter / s.weight);
        const Eigen::Vector3d extents = eigen.eigenvalues();
        if (!(extents[1] > kMinExtent * kMinExtent && extents[1] > 4.0 * extents[0])) {
            return Status::kDegenerate;
        }
        const Eigen::Vector3d n = eigen.eigenvectors().col(0).normalized();
        const Eigen::Vector3d before = out.normal_W;
        out.normal_W = n.dot(before) < 0.0 ? Eigen::Vector3d(-n) : n;
        out.distance_m = out.normal_W.dot(s.mean);
        if ((out.normal_W - before).squaredNorm() < 1e-10) {
            break;
        }
    }
    FACET_TRY(describe_plane(points, which, surface_sigma_m, out, bend));
    fit = out;
    return Status::kOk;
}

}  // namespace facet
