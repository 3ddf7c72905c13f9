// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/places/patch_search.h"

#include <Eigen/LU>

#include "mesh/places/bilinear.h"

namespace facet {
namespace {

constexpr int kInner = kPatchSide - 2;  ///< samples along a side that have a gradient
constexpr int kCount = kInner * kInner;
constexpr int kMaxSteps = 10;
constexpr float kSettled = 0.02F;                ///< a step that ends the search, in samples
constexpr float kMaxShift = 0.25F * kPatchSide;  ///< in samples
constexpr float kMinCorrelation = 0.8F;
constexpr float kMinContrast = 3.0F;  ///< standard deviation of the grey values

/// The inner samples without their mean, their gradients, and the inverse of the gradients' matrix.
struct Template {
    Eigen::Matrix<float, kCount, 1> grey;
    Eigen::Matrix<float, kCount, 2> gradient;
    Eigen::Matrix2f inverse;
    float norm = 0.0F;
};

bool prepare(const UprightPatch& patch, Template& made) {
    const auto at = [&patch](int i, int j) {
        return static_cast<float>(patch[static_cast<std::size_t>(j * kPatchSide + i)]);
    };
    int k = 0;
    for (int j = 1; j <= kInner; ++j) {
        for (int i = 1; i <= kInner; ++i, ++k) {
            made.grey[k] = at(i, j);
            made.gradient(k, 0) = 0.5F * (at(i + 1, j) - at(i - 1, j));
            made.gradient(k, 1) = 0.5F * (at(i, j + 1) - at(i, j - 1));
        }
    }
    made.grey.array() -= made.grey.mean();
    // Shifts that look like another brightness are not measured.
    made.gradient.rowwise() -= made.gradient.colwise().mean().eval();
    made.norm = made.grey.norm();
    const Eigen::Matrix2f h = made.gradient.transpose() * made.gradient;
    made.inverse = h.inverse();
    return made.norm > kMinContrast * kInner && h.determinant() > 0.05F * h.trace() * h.trace() / 4.0F &&
           made.inverse.allFinite();
}

void sample(const SquareSampler& sampler, const Eigen::Vector2f& shift, Eigen::Matrix<float, kCount, 1>& grey) {
    const Eigen::Vector2f corner = sampler.centre + (shift.x() - 0.5F * (kInner - 1)) * sampler.right +
                                   (shift.y() - 0.5F * (kInner - 1)) * sampler.down;
    int k = 0;
    for (int j = 0; j < kInner; ++j) {
        Eigen::Vector2f p = corner + static_cast<float>(j) * sampler.down;
        for (int i = 0; i < kInner; ++i, ++k, p += sampler.right) {
            grey[k] = bilinear(*sampler.image, p);
        }
    }
    grey.array() -= grey.mean();
}

}  // namespace

Status search_patch(const ImagePyramid& pyramid, const UprightSquare& square, int octave, const UprightPatch& patch,
                    Eigen::Vector2d& uv) {
    Template known;
    if (!prepare(patch, known)) {
        return Status::kDegenerate;
    }
    const double step_px = 2.0 * square.half_px(octave) / kPatchSide;
    const SquareSampler sampler(pyramid, square, step_px);
    Eigen::Vector2f shift = Eigen::Vector2f::Zero();
    Eigen::Matrix<float, kCount, 1> grey;
    for (int i = 0; i < kMaxSteps; ++i) {
        if (!sampler.covers(kPatchSide, shift) || shift.cwiseAbs().maxCoeff() > kMaxShift) {
            return Status::kNotFound;
        }
        sample(sampler, shift, grey);
        const float norm = grey.norm();
        if (!(norm > kMinContrast * kInner)) {
            return Status::kDegenerate;
        }
        const Eigen::Vector2f step =
            known.inverse * (known.gradient.transpose() * (known.grey - (known.norm / norm) * grey));
        if (step.norm() < kSettled) {
            if (grey.dot(known.grey) < kMinCorrelation * norm * known.norm) {
                return Status::kDegenerate;
            }
            const Eigen::Vector2d right(square.down.y(), -square.down.x());
            uv = square.centre +
                 step_px * (static_cast<double>(shift.x()) * right + static_cast<double>(shift.y()) * square.down);
            return Status::kOk;
        }
        shift += step;
    }
    return Status::kDegenerate;
}

}  // namespace facet
