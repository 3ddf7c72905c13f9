// SPDX-License-Identifier: BSD-2-Clause
// What a camera sees when the body it is mounted on has turned a little.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "drivers/replay_asl/png_decoder.h"
#include "estimator/geometry/camera_model.h"

namespace facet {

/// Resamples images of a camera as if the body were turned about its centre. Turns only, the camera stays where it is:
/// 0.3 mrad move a camera that is 0.1 m off the body's centre by 0.03 mm, which nobody sees. Thread-bound. Heap in the
/// constructor, and for the first image.
class ImageTurn {
public:
    /// @param R_B_C  camera to body
    ImageTurn(const CameraModel& camera, const Eigen::Quaterniond& R_B_C);

    /// Pixel v of the image gets what was seen at project(R_C_B Exp(theta) R_B_C unproject(v)), bilinear between
    /// pixels; what comes in over the edges is the edge's. Pixels outside the lens, and an image of another size, stay.
    /// @param theta_B  new attitude against the old one, about the body's axes (rad)
    void apply(const Eigen::Vector3d& theta_B, GreyImage& image);

private:
    CameraModel camera_;
    Eigen::Quaterniond R_B_C_;
    std::vector<Eigen::Vector3d> rays_;  ///< of the pixels, in rows; zero outside the lens
    GreyImage before_;
};

}  // namespace facet
