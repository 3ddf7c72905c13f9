// SPDX-License-Identifier: BSD-2-Clause
// Small pieces of plane through neighbouring depths of an image.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <span>
#include <vector>

#include "estimator/geometry/camera_model.h"
#include "mesh/volume/depth_samples.h"

namespace facet {

/// What one square of an image shows: points p of the camera with n . p = 1 (so 1 / Z = n . (x, y, 1)).
struct SurfacePatch {
    Eigen::Vector3f n_C = Eigen::Vector3f::Zero();  ///< (1/m); zero: nothing is known
    float sigma = 0.0F;                             ///< of 1 / Z (1/m)
    bool is_inferred = false;                       ///< from what lies around it
    float grey = 0.0F;                              ///< mean of the square in the image
    bool exists() const { return sigma > 0.0F; }
};

/// The squares into which an image is divided.
struct SquareLayout {
    int side_px = 0;
    int columns = 0;
    int rows = 0;
    double per_px = 0.0;  ///< change of the inverse depth per pixel of disparity (1/m/px)
    int count() const { return columns * rows; }
};

/// A plane in inverse depth through the samples around a square that agree with one another: those of a foreground and
/// of what is behind it do not, so that no patch bridges them. A square has a patch only if they lie about it, not to
/// one side; one without a sample of its own needs more of them. No heap. Reentrant. Deterministic.
/// @param samples  of each square, row by row
SurfacePatch fit_patch(std::span<const DepthSample> samples, const SquareLayout& layout, int square);

/// Finds the square of an image that a ray passes, by a raster of the undistorted plane. Heap in the constructor only.
class SquareRaster {
public:
    SquareRaster(const CameraModel& camera, int side_px, int columns, int rows);

    /// Middle of a square: normalised, undistorted.
    const Eigen::Vector2f& middle(std::size_t square) const { return middles_[square]; }
    /// -1: outside the image. @param xy  normalised, undistorted
    int square_at(float x, float y) const {
        const float u = (x - low_.x()) * per_cell_;
        const float v = (y - low_.y()) * per_cell_;
        return u >= 0.0F && v >= 0.0F && u < static_cast<float>(width_) && v < static_cast<float>(height_)
                   ? cells_[static_cast<std::size_t>(static_cast<int>(v) * width_ + static_cast<int>(u))]
                   : -1;
    }

    /// Whether a ball about a point of the camera may be in the image; if not, it is not.
    bool may_show(const Eigen::Vector3f& p_C, float radius) const {
        for (int axis = 0; axis < 2; ++axis) {
            const float low = low_[axis];
            const float high = low + static_cast<float>(axis == 0 ? width_ : height_) / per_cell_;
            if (p_C[axis] - low * p_C.z() < -radius * std::sqrt(1.0F + low * low) ||
                high * p_C.z() - p_C[axis] < -radius * std::sqrt(1.0F + high * high)) {
                return false;
            }
        }
        return true;
    }

private:
    Eigen::Vector2f low_ = Eigen::Vector2f::Zero();
    float per_cell_ = 1.0F;
    int width_ = 0;
    int height_ = 0;
    std::vector<int> cells_;
    std::vector<Eigen::Vector2f> middles_;
};

}  // namespace facet
