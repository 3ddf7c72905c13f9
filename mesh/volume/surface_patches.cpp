// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/volume/surface_patches.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "platform/base/fixed_vector.h"

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

/// A sample as the patch of a square sees it.
struct Neighbour {
    double rho = 0.0;       ///< inverse depth (1/m)
    double variance = 0.0;  ///< of it
    double x = 0.0;         ///< from the middle, on the undistorted plane
    double y = 0.0;
    double squares = 0.0;  ///< how far away, along the longer axis, at least one
    int right = 0;         ///< how many squares,
    int down = 0;
};

/// rho = value_0 + value_1 x + value_2 y.
struct Fit {
    Eigen::Vector3d value = Eigen::Vector3d::Zero();
    double variance = 0.0;  ///< of value_0
    int count = 0;
    Eigen::Vector2d aside = Eigen::Vector2d::Zero();  ///< mean place of the samples (squares)
};

class PatchFitter {
public:
    PatchFitter(std::span<const DepthSample> samples, const SquareLayout& layout, int square)
        : per_px_(layout.per_px), own_(samples[static_cast<std::size_t>(square)]) {
        const int column = square % layout.columns;
        const int row = square / layout.columns;
        for (int r = std::max(0, row - kReach); r <= std::min(layout.rows - 1, row + kReach); ++r) {
            for (int c = std::max(0, column - kReach); c <= std::min(layout.columns - 1, column + kReach); ++c) {
                const DepthSample& s = samples[static_cast<std::size_t>(r * layout.columns + c)];
                if (s.inverse_depth > 0.0F) {
                    const auto sigma = static_cast<double>(s.sigma);
                    near_.push_back({static_cast<double>(s.inverse_depth), sigma * sigma, static_cast<double>(s.xy.x()),
                                     static_cast<double>(s.xy.y()),
                                     std::max({1.0, std::abs(c - column) * 1.0, std::abs(r - row) * 1.0}), c - column,
                                     r - row});
                }
            }
        }
    }

    SurfacePatch fit() {
        const bool has_own = own_.inverse_depth > 0.0F;
        if (static_cast<int>(near_.size()) < kFewest) {
            return {};
        }
        Fit fit = begin(has_own);
        for (const double slack : {kSlopePx, kBendPx, kBendPx}) {
            if (!improve(slack, fit)) {
                return {};
            }
        }
        if (fit.count < (has_own ? kFewest : kFewestAround) || fit.aside.norm() > kMostAside) {
            return {};
        }
        const auto rho = static_cast<double>(own_.inverse_depth);
        if (has_own &&
            std::abs(rho - fit.value.x()) > kPatchSigmas * static_cast<double>(own_.sigma) + kBendPx * per_px_) {
            return {};
        }
        SurfacePatch patch;
        patch.n_C << fit.value.tail<2>().cast<float>(),
            static_cast<float>(fit.value.x() - fit.value.tail<2>().dot(middle_));
        patch.sigma = static_cast<float>(std::sqrt(fit.variance));
        const double cosine = fit.value.x() / (static_cast<double>(patch.n_C.norm()) * middle_.homogeneous().norm());
        return fit.value.x() > 0.0 && cosine > kLeastFacing && patch.n_C.allFinite() ? patch : SurfacePatch{};
    }

private:
    /// The square's own sample, or the median of those around it.
    Fit begin(bool has_own) {
        Fit fit;
        if (has_own) {
            middle_ = own_.xy.cast<double>();
            fit.value.x() = static_cast<double>(own_.inverse_depth);
            fit.variance = static_cast<double>(own_.sigma) * static_cast<double>(own_.sigma);
        } else {
            for (const Neighbour& s : near_) {
                middle_ += Eigen::Vector2d(s.x, s.y);
            }
            middle_ /= static_cast<double>(near_.size());
            auto sorted = near_;
            auto* const half = sorted.data() + sorted.size() / 2;
            std::nth_element(sorted.begin(), half, sorted.end(),
                             [](const auto& a, const auto& b) { return a.rho < b.rho; });
            fit.value.x() = half->rho;
            fit.variance = half->variance;
        }
        for (Neighbour& s : near_) {
            s.x -= middle_.x();
            s.y -= middle_.y();
        }
        return fit;
    }

    bool improve(double slack, Fit& fit) const {
        const double steepest = kSteepestSlope * fit.value.x();
        const double slope_weight = 1.0 / (steepest * steepest);
        double w0 = 0.0;
        double wx = 0.0;
        double wy = 0.0;
        double wxx = slope_weight;
        double wxy = 0.0;
        double wyy = slope_weight;
        Eigen::Vector3d g = Eigen::Vector3d::Zero();
        Fit next;
        for (const Neighbour& s : near_) {
            const double apart = std::abs(s.rho - fit.value.x() - fit.value.y() * s.x - fit.value.z() * s.y);
            const double more = std::max(0.0, apart - slack * per_px_ * s.squares);
            if (more * more > kPatchSigmas * kPatchSigmas * (s.variance + fit.variance)) {
                continue;
            }
            const double w = 1.0 / s.variance;
            w0 += w;
            wx += w * s.x;
            wy += w * s.y;
            wxx += w * s.x * s.x;
            wxy += w * s.x * s.y;
            wyy += w * s.y * s.y;
            g += w * s.rho * Eigen::Vector3d(1.0, s.x, s.y);
            next.aside += Eigen::Vector2d(s.right, s.down);
            ++next.count;
        }
        if (next.count < kFewest) {
            return false;
        }
        next.aside /= next.count;
        Eigen::Matrix3d h;
        h << w0, wx, wy, wx, wxx, wxy, wy, wxy, wyy;
        const Eigen::Matrix3d inverse = h.inverse();
        next.value = inverse * g;
        next.variance = kTogether * inverse(0, 0);
        fit = next;
        return std::isfinite(next.variance) && next.variance > 0.0;
    }

    static constexpr std::size_t kMost = (2 * kReach + 1) * (2 * kReach + 1);
    double per_px_;
    const DepthSample& own_;
    FixedVector<Neighbour, kMost> near_;
    Eigen::Vector2d middle_ = Eigen::Vector2d::Zero();
};

}  // namespace

SurfacePatch fit_patch(std::span<const DepthSample> samples, const SquareLayout& layout, int square) {
    return PatchFitter(samples, layout, square).fit();
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
