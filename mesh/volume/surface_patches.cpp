// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/volume/surface_patches.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace facet {
namespace {

constexpr int kReach = 2;               // squares to either side whose samples join
constexpr double kPatchSigmas = 3.0;    // within which a sample agrees with the patch,
constexpr double kSlopePx = 0.4;        // what an unknown slope adds per square,
constexpr double kBendPx = 0.1;         // and what a curved surface does
constexpr int kFewest = 6;              // samples of a patch
constexpr int kFewestAround = 10;       // of one that has none of its own
constexpr double kMostAside = 0.8;      // squares: their mean from its middle
constexpr double kTogether = 4.0;       // samples that share most of their windows' pixels
constexpr double kSteepestSlope = 4.0;  // slope of a surface, about which most are less
constexpr double kLeastFacing = 0.15;   // of the angle between ray and normal

/// Plane in inverse depth about a square's middle.
struct Fit {
    Eigen::Vector3d value = Eigen::Vector3d::Zero();  ///< inverse depth in the middle, slopes
    double sigma = 0.0;
    int count = 0;
    Eigen::Vector2d aside = Eigen::Vector2d::Zero();  ///< mean place of the samples (squares)
};

class PatchFitter {
public:
    PatchFitter(const std::vector<DepthSample>& samples, int columns, int rows, double per_px)
        : samples_(samples), columns_(columns), rows_(rows), per_px_(per_px) {}

    SurfacePatch fit(int column, int row) const {
        const DepthSample& own = samples_[static_cast<std::size_t>(row * columns_ + column)];
        const bool has_own = own.inverse_depth > 0.0F;
        Fit fit;
        Eigen::Vector2d middle;
        if (!begin(column, row, fit, middle)) {
            return {};
        }
        for (const double slack : {kSlopePx, kBendPx, kBendPx}) {
            if (!improve(column, row, middle, slack, fit)) {
                return {};
            }
        }
        if (fit.count < (has_own ? kFewest : kFewestAround) || fit.aside.norm() > kMostAside) {
            return {};
        }
        if (has_own && std::abs(static_cast<double>(own.inverse_depth) - at(fit.value, middle, own)) >
                           kPatchSigmas * static_cast<double>(own.sigma) + kBendPx * per_px_) {
            return {};
        }
        SurfacePatch patch;
        patch.n_C << fit.value.tail<2>().cast<float>(),
            static_cast<float>(fit.value.x() - fit.value.tail<2>().dot(middle));
        patch.sigma = static_cast<float>(fit.sigma);
        const double cosine = fit.value.x() / (static_cast<double>(patch.n_C.norm()) * middle.homogeneous().norm());
        return fit.value.x() > 0.0 && cosine > kLeastFacing ? patch : SurfacePatch{};
    }

private:
    static double at(const Eigen::Vector3d& value, const Eigen::Vector2d& middle, const DepthSample& s) {
        return value.x() + value.tail<2>().dot(s.xy.cast<double>() - middle);
    }

    template <typename Visit>
    void around(int column, int row, const Visit& visit) const {
        for (int r = std::max(0, row - kReach); r <= std::min(rows_ - 1, row + kReach); ++r) {
            for (int c = std::max(0, column - kReach); c <= std::min(columns_ - 1, column + kReach); ++c) {
                const DepthSample& s = samples_[static_cast<std::size_t>(r * columns_ + c)];
                if (s.inverse_depth > 0.0F) {
                    visit(s, Eigen::Vector2d(c - column, r - row));
                }
            }
        }
    }

    /// The square's own sample, or the median of those around it.
    bool begin(int column, int row, Fit& fit, Eigen::Vector2d& middle) const {
        const DepthSample& own = samples_[static_cast<std::size_t>(row * columns_ + column)];
        std::vector<const DepthSample*> near;
        middle.setZero();
        around(column, row, [&](const DepthSample& s, const Eigen::Vector2d&) {
            near.push_back(&s);
            middle += s.xy.cast<double>();
        });
        if (static_cast<int>(near.size()) < kFewest) {
            return false;
        }
        middle /= static_cast<double>(near.size());
        const DepthSample* first = &own;
        if (own.inverse_depth <= 0.0F) {
            auto* const half = near.data() + near.size() / 2;
            std::nth_element(near.data(), half, near.data() + near.size(),
                             [](const auto* a, const auto* b) { return a->inverse_depth < b->inverse_depth; });
            first = *half;
        } else {
            middle = own.xy.cast<double>();
        }
        fit.value = {static_cast<double>(first->inverse_depth), 0.0, 0.0};
        fit.sigma = static_cast<double>(first->sigma);
        return true;
    }

    bool improve(int column, int row, const Eigen::Vector2d& middle, double slack, Fit& fit) const {
        const double steepest = kSteepestSlope * fit.value.x();
        Eigen::Matrix3d h = Eigen::Vector3d(0.0, 1.0, 1.0).asDiagonal();
        h *= 1.0 / (steepest * steepest);
        Eigen::Vector3d g = Eigen::Vector3d::Zero();
        Fit next;
        double weights = 0.0;
        around(column, row, [&](const DepthSample& s, const Eigen::Vector2d& offset) {
            const auto sigma = static_cast<double>(s.sigma);
            const double apart = static_cast<double>(s.inverse_depth) - at(fit.value, middle, s);
            const double more = slack * per_px_ * std::max(1.0, offset.lpNorm<Eigen::Infinity>());
            if (std::abs(apart) > kPatchSigmas * std::hypot(sigma, fit.sigma) + more) {
                return;
            }
            const Eigen::Vector3d j = (s.xy.cast<double>() - middle).homogeneous();
            const Eigen::Vector3d a(1.0, j.x(), j.y());
            const double w = 1.0 / (sigma * sigma);
            h += w * a * a.transpose();
            g += w * static_cast<double>(s.inverse_depth) * a;
            weights += w;
            next.aside += offset;
            ++next.count;
        });
        if (next.count < kFewest) {
            return false;
        }
        next.aside /= next.count;
        const Eigen::LDLT<Eigen::Matrix3d> solver(h);
        next.value = solver.solve(g);
        next.sigma = std::sqrt(kTogether * solver.solve(Eigen::Vector3d::UnitX()).x());
        fit = next;
        return true;
    }

    const std::vector<DepthSample>& samples_;
    int columns_;
    int rows_;
    double per_px_;
};

}  // namespace

std::vector<SurfacePatch> fit_patches(const std::vector<DepthSample>& samples, int columns, int rows, double per_px) {
    const PatchFitter fitter(samples, columns, rows, per_px);
    std::vector<SurfacePatch> patches(samples.size());
    for (int row = 0; row < rows; ++row) {
        for (int column = 0; column < columns; ++column) {
            patches[static_cast<std::size_t>(row * columns + column)] = fitter.fit(column, row);
        }
    }
    return patches;
}

SquareRaster::SquareRaster(const CameraModel& camera, int side_px, int columns, int rows) {
    Eigen::Vector2f high = Eigen::Vector2f::Constant(-1e9F);
    low_ = -high;
    for (int i = 0; i < columns * rows; ++i) {
        const Eigen::Vector2i square(i % columns, i / columns);
        const Eigen::Vector2d uv = side_px * (square.cast<double>().array() + 0.5) - 0.5;
        Eigen::Vector2d xy;
        middles_.push_back(ok(camera.unproject(uv, xy)) ? Eigen::Vector2f(xy.cast<float>()) : Eigen::Vector2f::Zero());
        low_ = low_.cwiseMin(middles_.back());
        high = high.cwiseMax(middles_.back());
    }
    per_cell_ = static_cast<float>(2.0 * camera.focal_px() / side_px);
    width_ = static_cast<int>((high.x() - low_.x()) * per_cell_) + 1;
    height_ = static_cast<int>((high.y() - low_.y()) * per_cell_) + 1;
    for (int i = 0; i < width_ * height_; ++i) {
        const Eigen::Vector2i cell(i % width_, i / width_);
        const Eigen::Vector2d middle = cell.cast<double>().array() + 0.5;
        const Eigen::Vector2d xy = low_.cast<double>() + middle / static_cast<double>(per_cell_);
        Eigen::Vector2d uv;
        int square = -1;
        if (ok(camera.project(xy.homogeneous(), uv)) && camera.in_image(uv, 0.0)) {
            const int column = static_cast<int>((uv.x() + 0.5) / side_px);
            const int row = static_cast<int>((uv.y() + 0.5) / side_px);
            square = column < columns && row < rows ? row * columns + column : -1;
        }
        cells_.push_back(square);
    }
}

}  // namespace facet
