// SPDX-License-Identifier: BSD-2-Clause
// Cholesky factor of a 3x3 matrix, written out: Eigen's loops are optimized for larger ones.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "platform/base/status.h"

namespace facet {

/// H = L L^T, L lower triangular; the diagonal is kept inverted. [Golub13] Sec. 4.2. Reentrant. No heap.
class Cholesky3 {
public:
    /// Reads the lower triangle. @return kDegenerate if H is not positive definite (object unusable).
    Status factorize(const Eigen::Matrix3d& h) {
        if (!invert_root(h(0, 0), i0_)) {
            return Status::kDegenerate;
        }
        l10_ = h(1, 0) * i0_;
        l20_ = h(2, 0) * i0_;
        if (!invert_root(h(1, 1) - l10_ * l10_, i1_)) {
            return Status::kDegenerate;
        }
        l21_ = (h(2, 1) - l20_ * l10_) * i1_;
        return invert_root(h(2, 2) - l20_ * l20_ - l21_ * l21_, i2_) ? Status::kOk : Status::kDegenerate;
    }

    /// L^-1 b
    Eigen::Vector3d whiten(const Eigen::Vector3d& b) const {
        const double x = b.x() * i0_;
        const double y = (b.y() - l10_ * x) * i1_;
        return {x, y, (b.z() - l20_ * x - l21_ * y) * i2_};
    }

    /// Turns each row a^T of a matrix with three columns into (L^-1 a)^T, in place: X becomes X L^-T.
    template <class Matrix>
    void whiten_rows(Matrix& x) const {
        x.col(0) *= i0_;
        x.col(1) = (x.col(1) - l10_ * x.col(0)) * i1_;
        x.col(2) = (x.col(2) - l20_ * x.col(0) - l21_ * x.col(1)) * i2_;
    }

    /// H^-1 b
    Eigen::Vector3d solve(const Eigen::Vector3d& b) const {
        const Eigen::Vector3d w = whiten(b);
        const double z = w.z() * i2_;
        const double y = (w.y() - l21_ * z) * i1_;
        return {(w.x() - l10_ * y - l20_ * z) * i0_, y, z};
    }

private:
    static bool invert_root(double pivot, double& out) {
        out = 1.0 / std::sqrt(pivot);
        return pivot > 0.0 && std::isfinite(out);
    }

    double i0_ = 0.0;
    double i1_ = 0.0;
    double i2_ = 0.0;
    double l10_ = 0.0;
    double l20_ = 0.0;
    double l21_ = 0.0;
};

}  // namespace facet
