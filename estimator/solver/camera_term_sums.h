// SPDX-License-Identifier: BSD-2-Clause
// The part of the normal equations that belongs to the parameters of single cameras, summed over the landmarks.
#pragma once

#include <Eigen/Core>
#include <array>

#include "estimator/factors/stereo_factor.h"
#include "estimator/solver/reduced_system.h"

namespace facet {

/// Kept apart from the system until all landmarks are in: there its columns lie far apart, here they are a few
/// kilobytes that stay near. Parameters in the order of CameraTerms, padded to whole vectors.
/// Thread-bound. No heap. About 55 kB.
class CameraTermSums {
public:
    static constexpr int kPaddedPose = StereoLinearization::kPaddedPoseDim;
    static constexpr int kPaddedDim = kLensDim + StereoLinearization::kPaddedRightDim;
    using PoseBlock = Eigen::Matrix<double, kPaddedPose, kPaddedDim>;

    /// @param first_row  row of the system where the parameters of single cameras begin
    /// @param with_matrix  whether more than the gradient is needed
    void reset(int keyframes, int first_row, bool with_matrix) {
        row = first_row;
        g.setZero();
        if (!with_matrix) {
            return;
        }
        h.setZero();
        for (int k = 0; k < keyframes; ++k) {
            h_pose[static_cast<std::size_t>(k)].setZero();
        }
    }

    /// Adds the sums to a system of as many keyframes.
    void add_into(ReducedSystem& system) const {
        system.g().segment<kCameraTermsDim>(row) += g.head<kCameraTermsDim>();
        if (!system.has_matrix()) {
            return;
        }
        auto system_h = system.h();
        system_h.block<kCameraTermsDim, kCameraTermsDim>(row, row) +=
            h.topLeftCorner<kCameraTermsDim, kCameraTermsDim>();
        for (int k = 0; k < system.keyframes(); ++k) {
            system_h.block<kPoseDim, kCameraTermsDim>(system.offset(k), row) +=
                h_pose[static_cast<std::size_t>(k)].topLeftCorner<kPoseDim, kCameraTermsDim>();
        }
    }

    int row = 0;
    Eigen::Matrix<double, kPaddedDim, kPaddedDim> h;
    Eigen::Matrix<double, kPaddedDim, 1> g;
    std::array<PoseBlock, kMaxKeyframes> h_pose;  ///< rows of a keyframe's pose
};

}  // namespace facet
