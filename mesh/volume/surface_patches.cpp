// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/volume/surface_patches.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "estimator/frontend/simd.h"

namespace facet {
namespace {

using simd::Floats;
using simd::Ints;

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

constexpr std::size_t kMost = (2 * kReach + 1) * (2 * kReach + 1);
constexpr std::size_t kPadded = (kMost + simd::kLanes - 1) / simd::kLanes * simd::kLanes;
using Column = std::array<float, kPadded>;

/// Samples as the patch of a square sees them; beyond the last one their weight is 0.
struct Neighbours {
    int count = 0;
    Column rho{};       ///< inverse depths, from the first guess of the square's (1/m)
    Column variance{};  ///< of them
    Column weight{};    ///< its inverse, or 0
    Column x{};         ///< from the middle, on the undistorted plane
    Column y{};
    Column squares{};  ///< how far away, along the longer axis, at least one
    Column right{};    ///< how many squares,
    Column down{};
};

/// rho = first guess + value_0 + value_1 x + value_2 y.
struct Fit {
    Eigen::Vector3d value = Eigen::Vector3d::Zero();
    double variance = 0.0;  ///< of value_0
    int count = 0;
    Eigen::Vector2d aside = Eigen::Vector2d::Zero();  ///< mean place of the samples (squares)
};

class PatchFitter {
public:
    PatchFitter(std::span<const DepthSample> samples, const SquareLayout& layout, int square)
        : per_px_(static_cast<float>(layout.per_px)), own_(samples[static_cast<std::size_t>(square)]) {
        const int column = square % layout.columns;
        const int row = square / layout.columns;
        std::size_t n = 0;
        for (int r = std::max(0, row - kReach); r <= std::min(layout.rows - 1, row + kReach); ++r) {
            for (int c = std::max(0, column - kReach); c <= std::min(layout.columns - 1, column + kReach); ++c) {
                const DepthSample& s = samples[static_cast<std::size_t>(r * layout.columns + c)];
                if (s.inverse_depth > 0.0F) {
                    near_.rho[n] = s.inverse_depth;
                    near_.variance[n] = s.sigma * s.sigma;
                    near_.x[n] = s.xy.x();
                    near_.y[n] = s.xy.y();
                    near_.right[n] = static_cast<float>(c - column);
                    near_.down[n] = static_cast<float>(r - row);
                    near_.squares[n] = static_cast<float>(std::max({1, std::abs(c - column), std::abs(r - row)}));
                    ++n;
                }
            }
        }
        near_.count = static_cast<int>(n);
    }

    SurfacePatch fit() {
        const bool has_own = own_.inverse_depth > 0.0F;
        if (near_.count < kFewest) {
            return {};
        }
        Fit fit;
        begin(has_own, fit);
        for (const double slack : {kSlopePx, kBendPx, kBendPx}) {
            if (!improve(static_cast<float>(slack) * per_px_, fit)) {
                return {};
            }
        }
        if (fit.count < (has_own ? kFewest : kFewestAround) || fit.aside.norm() > kMostAside) {
            return {};
        }
        if (has_own && std::abs(fit.value.x()) >
                           kPatchSigmas * static_cast<double>(own_.sigma) + kBendPx * static_cast<double>(per_px_)) {
            return {};
        }
        const double rho = static_cast<double>(guess_) + fit.value.x();
        const Eigen::Vector2d middle = middle_.cast<double>();
        SurfacePatch patch;
        patch.n_C << fit.value.tail<2>().cast<float>(), static_cast<float>(rho - fit.value.tail<2>().dot(middle));
        patch.sigma = static_cast<float>(std::sqrt(fit.variance));
        const double cosine = rho / (static_cast<double>(patch.n_C.norm()) * middle.homogeneous().norm());
        return rho > 0.0 && cosine > kLeastFacing && patch.n_C.allFinite() ? patch : SurfacePatch{};
    }

private:
    /// The square's own sample, or the median of those around it.
    void begin(bool has_own, Fit& fit) {
        const auto count = static_cast<std::size_t>(near_.count);
        if (has_own) {
            middle_ = own_.xy;
            guess_ = own_.inverse_depth;
            fit.variance = static_cast<double>(own_.sigma) * static_cast<double>(own_.sigma);
        } else {
            std::array<std::uint8_t, kMost> sorted;
            for (std::size_t i = 0; i < count; ++i) {
                middle_ += Eigen::Vector2f(near_.x[i], near_.y[i]);
                sorted[i] = static_cast<std::uint8_t>(i);
            }
            middle_ /= static_cast<float>(count);
            auto* const half = sorted.data() + count / 2;
            std::nth_element(sorted.data(), half, sorted.data() + count,
                             [&](auto a, auto b) { return near_.rho[a] < near_.rho[b]; });
            guess_ = near_.rho[*half];
            fit.variance = static_cast<double>(near_.variance[*half]);
        }
        for (std::size_t i = 0; i < count; ++i) {
            near_.rho[i] -= guess_;
            near_.x[i] -= middle_.x();
            near_.y[i] -= middle_.y();
            near_.weight[i] = 1.0F / near_.variance[i];
        }
    }

    /// To the samples that lie on it. @param slack  1/m a square
    bool improve(float slack, Fit& fit) const {
        const auto v0 = static_cast<float>(fit.value.x());
        const auto vx = static_cast<float>(fit.value.y());
        const auto vy = static_cast<float>(fit.value.z());
        const auto own_variance = static_cast<float>(fit.variance);
        constexpr auto kMostSquared = static_cast<float>(kPatchSigmas * kPatchSigmas);
        Floats count{}, right{}, down{}, w0{}, wx{}, wy{}, wxx{}, wxy{}, wyy{}, g0{}, gx{}, gy{};
        for (std::size_t i = 0; i < kPadded; i += simd::kLanes) {
            const auto of = [i](const Column& column) { return simd::load(column.data() + i); };
            const Floats rho = of(near_.rho);
            const Floats x = of(near_.x);
            const Floats y = of(near_.y);
            const Floats off = rho - v0 - vx * x - vy * y;
            const Floats more = (off < 0.0F ? -off : off) - slack * of(near_.squares);
            const Ints is_on = (more <= 0.0F) | (more * more <= kMostSquared * (of(near_.variance) + own_variance));
            const Floats w = is_on ? of(near_.weight) : Floats{};
            const Ints counts = is_on & (of(near_.weight) > 0.0F);
            count += counts ? simd::splat(1.0F) : Floats{};
            right += is_on ? of(near_.right) : Floats{};
            down += is_on ? of(near_.down) : Floats{};
            w0 += w;
            wx += w * x;
            wy += w * y;
            wxx += w * x * x;
            wxy += w * x * y;
            wyy += w * y * y;
            g0 += w * rho;
            gx += w * rho * x;
            gy += w * rho * y;
        }
        Fit next;
        next.count = static_cast<int>(simd::sum(count));
        if (next.count < kFewest) {
            return false;
        }
        const auto sum = [](const Floats& v) { return static_cast<double>(simd::sum(v)); };
        next.aside = Eigen::Vector2d(sum(right), sum(down)) / next.count;
        const double steepest = kSteepestSlope * (static_cast<double>(guess_) + fit.value.x());
        const double slope_weight = 1.0 / (steepest * steepest);
        Eigen::Matrix3d h;
        h << sum(w0), sum(wx), sum(wy), sum(wx), sum(wxx) + slope_weight, sum(wxy), sum(wy), sum(wxy),
            sum(wyy) + slope_weight;
        const Eigen::Matrix3d inverse = h.inverse();
        next.value = inverse * Eigen::Vector3d(sum(g0), sum(gx), sum(gy));
        next.variance = kTogether * inverse(0, 0);
        fit = next;
        return std::isfinite(next.variance) && next.variance > 0.0;
    }

    float per_px_;
    const DepthSample& own_;
    Neighbours near_;
    float guess_ = 0.0F;  ///< of the square's inverse depth (1/m)
    Eigen::Vector2f middle_ = Eigen::Vector2f::Zero();
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
