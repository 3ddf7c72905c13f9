// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/calibrate/residual_picture.h"

#include <algorithm>
#include <cmath>

#include "app/support/input_error.h"
#include "app/support/png_writer.h"

namespace facet {
namespace {

constexpr int kCellPx = 40;
constexpr double kSingleScale = 10.0;
constexpr double kMeanScale = 100.0;
constexpr std::size_t kMinPerCell = 10;
constexpr std::uint8_t kWhite = 255;
constexpr std::uint8_t kGrey = 205;
constexpr std::uint8_t kBlack = 0;

struct Canvas {
    int width;
    int height;
    std::vector<std::uint8_t> pixels;

    void dot(int u, int v, std::uint8_t grey) {
        if (u >= 0 && v >= 0 && u < width && v < height) {
            std::uint8_t& pixel =
                pixels[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u)];
            pixel = std::min(pixel, grey);
        }
    }
    void line(const Eigen::Vector2d& from, const Eigen::Vector2d& by, std::uint8_t grey) {
        const double longest = std::min(by.cwiseAbs().maxCoeff(), static_cast<double>(width + height));
        const int steps = std::max(1, static_cast<int>(std::ceil(longest)));
        for (int i = 0; i <= steps; ++i) {
            const Eigen::Vector2d at = from + by * (static_cast<double>(i) / steps);
            dot(static_cast<int>(std::lround(at.x())), static_cast<int>(std::lround(at.y())), grey);
        }
    }
};

struct Cell {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    std::size_t count = 0;
};

}  // namespace

void write_residual_picture(const std::string& path, const CameraIntrinsics& size,
                            const std::vector<SightingResidual>& residuals, int camera) {
    Canvas canvas{size.width, size.height, {}};
    canvas.pixels.assign(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height), kWhite);
    const int columns = size.width / kCellPx + 1;
    std::vector<Cell> cells(static_cast<std::size_t>(columns) * static_cast<std::size_t>(size.height / kCellPx + 1));
    for (const SightingResidual& r : residuals) {
        if (r.camera != camera || r.px.x() < 0.0 || r.px.y() < 0.0 || r.px.x() >= size.width ||
            r.px.y() >= size.height) {
            continue;
        }
        canvas.line(r.px, kSingleScale * r.error_px, kGrey);
        const int cell = static_cast<int>(r.px.y()) / kCellPx * columns + static_cast<int>(r.px.x()) / kCellPx;
        cells[static_cast<std::size_t>(cell)].sum += r.error_px;
        ++cells[static_cast<std::size_t>(cell)].count;
    }
    for (std::size_t i = 0; i < cells.size(); ++i) {
        if (cells[i].count < kMinPerCell) {
            continue;
        }
        const int row = static_cast<int>(i) / columns;
        const int column = static_cast<int>(i) % columns;
        const Eigen::Vector2d centre((column + 0.5) * kCellPx, (row + 0.5) * kCellPx);
        const Eigen::Vector2d mean = cells[i].sum / static_cast<double>(cells[i].count);
        canvas.line(centre, kMeanScale * mean, kBlack);
        canvas.line(centre - Eigen::Vector2d(1.0, 0.0), {2.0, 0.0}, kBlack);
        canvas.line(centre - Eigen::Vector2d(0.0, 1.0), {0.0, 2.0}, kBlack);
    }
    if (!ok(write_png(path, {canvas.pixels.data(), size.width, size.height, size.width}))) {
        throw InputError(path + ": cannot be written");
    }
}

}  // namespace facet
