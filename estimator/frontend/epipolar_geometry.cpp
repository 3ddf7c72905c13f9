// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/epipolar_geometry.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace facet {
void EpipolarGeometry::configure(const StereoRig& rig) {
    given_ = rig;
    is_corrected_ = false;
    set_right(rig.right, rig.T_B_C1);
}

void EpipolarGeometry::correct(const CameraCorrections& corrections) {
    corrections_ = corrections;
    is_corrected_ = true;
    const Se3& given = given_.T_B_C1;
    set_right(corrected(given_.right, corrections.lens[1]),
              {(given.q * corrections.right.q).normalized(), given.p + corrections.right.p});
}

void EpipolarGeometry::set_right(const CameraModel& camera, const Se3& T_B_C1) {
    right_ = camera;
    const Se3 T_C1_C0 = T_B_C1.inverse() * given_.T_B_C0;
    R_C1_B_ = T_B_C1.R().transpose();
    R_C1_C0_ = T_C1_C0.R();
    p_C1_C0_ = T_C1_C0.p;
}

Status EpipolarGeometry::ray_of(const Eigen::Vector2d& left_uv, Ray& ray) const {
    Ray found;
    Eigen::Matrix2d d_xy_d_uv;
    found.uv = left_uv;
    FACET_TRY(given_.left.unproject(left_uv, found.given_xy, &d_xy_d_uv));
    Eigen::Vector2d xy = found.given_xy;
    found.d_xy_d_lens.setZero();
    if (is_corrected_) {
        found.d_xy_d_lens = d_xy_d_lens(given_.left, xy).cast<double>();
        xy += found.d_xy_d_lens * corrections_.lens[0];
    }
    found.direction_C1 = R_C1_C0_ * xy.homogeneous();
    found.d_direction_d_uv = R_C1_C0_.leftCols<2>() * d_xy_d_uv;
    ray = found;
    return Status::kOk;
}

Status EpipolarGeometry::point_at(const Ray& ray, double inverse_depth, Eigen::Vector2d& right_uv,
                                  Eigen::Matrix2f& d_right_d_left) const {
    Eigen::Matrix<double, 2, 3> d_uv_d_p;
    const Eigen::Vector3d p = ray.direction_C1 + inverse_depth * p_C1_C0_;
    FACET_TRY(right_.project(p, right_uv, &d_uv_d_p));
    // Fronto-parallel: the inverse depth stays the same over the surface.
    d_right_d_left = (d_uv_d_p * ray.d_direction_d_uv).cast<float>();
    return Status::kOk;
}

double EpipolarGeometry::line_sigma(const Ray& ray, const Eigen::Vector2d& normal,
                                    const Eigen::Matrix<double, 2, kLensDim>& d_right_d_lens,
                                    double inverse_depth) const {
    // e = n . (x - q.xy / q.z), q = p_C1(rho). The right lens moves x, the left one q; the right camera's pose makes it
    // q + q x theta - rho R_C1_B dp.
    const Eigen::Vector3d q = ray.direction_C1 + inverse_depth * p_C1_C0_;
    const Eigen::Vector2d xy = q.head<2>() / q.z();
    const Eigen::Vector3d d_e_d_q = -Eigen::Vector3d(normal.x(), normal.y(), -normal.dot(xy)) / q.z();
    Eigen::Matrix<double, CameraCorrections::kDim, 1> d_e;
    d_e << (R_C1_C0_.leftCols<2>() * ray.d_xy_d_lens).transpose() * d_e_d_q, d_e_d_q.cross(q),
        -inverse_depth * (R_C1_B_.transpose() * d_e_d_q), d_right_d_lens.transpose() * normal;
    return std::sqrt(std::max(0.0, d_e.dot(corrections_.covariance * d_e)));
}

Status EpipolarGeometry::compare(const Ray& ray, const Eigen::Vector2d& right_uv, Place& place) const {
    Place found;
    Eigen::Matrix2d d_xy_d_uv;
    FACET_TRY(given_.right.unproject(right_uv, found.given_xy, &d_xy_d_uv));
    Eigen::Vector3d x = found.given_xy.homogeneous();
    Eigen::Matrix<double, 2, kLensDim> d_right_d_lens = Eigen::Matrix<double, 2, kLensDim>::Zero();
    if (is_corrected_) {
        d_right_d_lens = d_xy_d_lens(given_.right, found.given_xy).cast<double>();
        x.head<2>() += d_right_d_lens * corrections_.lens[1];
    }
    // The inverse depth that comes nearest on the line: x ~ d + rho t.
    const Eigen::Vector3d line = p_C1_C0_.cross(ray.direction_C1);
    const Eigen::Vector3d a = x.cross(p_C1_C0_);
    const double px_per_off = 1.0 / (d_xy_d_uv.transpose() * line.head<2>()).norm();
    found.off_px = std::abs(line.dot(x)) * px_per_off;
    found.inverse_depth = -a.dot(x.cross(ray.direction_C1)) / a.squaredNorm();
    if (is_corrected_) {
        found.off_sigma_px = px_per_off * line_sigma(ray, line.head<2>(), d_right_d_lens, found.inverse_depth);
    }
    place = found;
    return Status::kOk;
}

}  // namespace facet
