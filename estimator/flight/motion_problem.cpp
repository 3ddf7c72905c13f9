// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/flight/motion_problem.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "estimator/geometry/so3.h"

namespace facet {
namespace {

constexpr double kLeastDepth_m = 0.1;
// Of a ray over that of the first sighting: behind.
constexpr double kLeastDepthRatio = 0.05;
// Of a point's inverse depth, around zero: keeps it where there is no parallax (1/m).
constexpr double kInverseDepthSigma = 3.0;
constexpr int kPointSteps = 3;
// Priors, wide: a drone's speed, gravity from the mean force.
constexpr double kVelocitySigma = 5.0;
constexpr double kGravitySigma = 4.0;
constexpr double kGravityNormSigma = 0.02;
// Of a shape's path, where its scale is sought; and a depth where none is known (m).
constexpr double kPathSigma_m = 0.02;
constexpr double kUsualDepth_m = 2.0;

double inverse_square(double sigma) { return 1.0 / (sigma * sigma); }

}  // namespace

void MotionProblem::configure(double gravity_m_per_s2, double bearing_sigma) {
    gravity_m_per_s2_ = gravity_m_per_s2;
    bearing_sigma_ = bearing_sigma;
    clear();
}

void MotionProblem::clear() {
    points_.clear();
    sights_.clear();
}

bool MotionProblem::add_point(std::span<const MotionSight> sights) {
    if (points_.size() == points_.capacity() || sights.size() > kMostSights) {
        return false;
    }
    points_.push_back({sights_.size(), sights.size(), Eigen::Vector3d::Zero()});
    sights_.insert(sights_.end(), sights.begin(), sights.end());
    return true;
}

Eigen::Vector3d MotionProblem::meet(Sights sights, const Places& places, const Centres& centres,
                                    const Values& weights) {
    Eigen::Matrix3d a = 1e-9 * Eigen::Matrix3d::Identity();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < sights.size(); ++k) {
        const Eigen::Vector3d d = places[sights[k].place].R * *sights[k].d_B;
        const Eigen::Matrix3d across = weights[k] * (Eigen::Matrix3d::Identity() - d * d.transpose());
        a += across;
        b += across * centres[k];
    }
    return a.inverse() * b;
}

MotionProblem::ShapeCentre MotionProblem::shape_centre(const MotionPlace& place, const Eigen::Vector3d& p_B_C) {
    ShapeCentre m;
    m.leftCols<3>() = place.t_s * Eigen::Matrix3d::Identity();
    m.middleCols<3>(3) = 0.5 * place.t_s * place.t_s * Eigen::Matrix3d::Identity();
    m.col(6) = place.p + place.R * p_B_C;
    return m;
}

MotionProblem::Centres MotionProblem::centres_of(Sights sights, const Places& places, const Shape& z) {
    Centres centres;
    for (const MotionSight& sight : sights) {
        centres.push_back(shape_centre(places[sight.place], *sight.p_B_C) * z);
    }
    return centres;
}

MotionProblem::Centres MotionProblem::centres_of(Sights sights, const Places& places, const Unknowns& x) {
    Shape z;
    z << x.head<6>(), 1.0;
    Centres centres = centres_of(sights, places, z);
    for (std::size_t k = 0; k < sights.size(); ++k) {
        centres[k] += places[sights[k].place].d_p_d_b.rightCols<3>() * x.segment<3>(kAccelBiasAt);
    }
    return centres;
}

MotionProblem::Form MotionProblem::shape_form(const Places& places, const Shape* z) const {
    Form form = Form::Zero();
    for (const Point& point : points_) {
        const Sights sights = sights_of(point);
        Values weights(sights.size(), inverse_square(kUsualDepth_m));
        if (z != nullptr) {
            const Centres centres = centres_of(sights, places, *z);
            const Eigen::Vector3d X = meet(sights, places, centres, weights);
            for (std::size_t k = 0; k < sights.size(); ++k) {
                weights[k] = inverse_square(std::max((X - centres[k]).norm(), kLeastDepth_m * z->norm()));
            }
        }
        Eigen::Matrix3d a = 1e-9 * Eigen::Matrix3d::Identity();
        ShapeCentre am = ShapeCentre::Zero();
        for (std::size_t k = 0; k < sights.size(); ++k) {
            const MotionPlace& place = places[sights[k].place];
            const Eigen::Vector3d d = place.R * *sights[k].d_B;
            const ShapeCentre m = shape_centre(place, *sights[k].p_B_C);
            const Eigen::Matrix3d across = weights[k] * (Eigen::Matrix3d::Identity() - d * d.transpose());
            a += across;
            am.noalias() += across * m;
            form.noalias() += m.transpose() * (across * m);
        }
        form.noalias() -= am.transpose() * (a.inverse() * am);
    }
    return form;
}

MotionProblem::Form MotionProblem::path_form(const Places& places) {
    Form form = Form::Zero();
    for (const MotionPlace& place : places) {
        const ShapeCentre m = shape_centre(place, Eigen::Vector3d::Zero());
        form.noalias() += m.transpose() * m;
    }
    form.diagonal().array() += 1e-9 * form.trace();
    return form;
}

bool MotionProblem::is_mirrored(const Places& places, const Shape& z) const {
    int behind = 0;
    for (const Point& point : points_) {
        const Sights sights = sights_of(point);
        const Centres centres = centres_of(sights, places, z);
        const Eigen::Vector3d X = meet(sights, places, centres, Values(sights.size(), 1.0));
        const MotionSight& first = sights.front();
        behind += (X - centres.front()).dot(places[first.place].R * *first.d_B) < 0.0 ? 1 : 0;
    }
    return 2 * behind > static_cast<int>(points_.size());
}

Status MotionProblem::find_shape(const Places& places, Shape& z) const {
    const Form path = path_form(places);
    for (int pass = 0; pass < 2; ++pass) {
        const Form form = shape_form(places, pass == 0 ? nullptr : &z);
        const Eigen::GeneralizedSelfAdjointEigenSolver<Form> solver(form, path);
        if (solver.info() != Eigen::Success) {
            return Status::kDegenerate;
        }
        z = solver.eigenvectors().col(0);
    }
    z *= is_mirrored(places, z) ? -1.0 : 1.0;
    return Status::kOk;
}

void MotionProblem::place_points(const Places& places, const Unknowns& x) {
    for (Point& point : points_) {
        const Sights sights = sights_of(point);
        const Centres centres = centres_of(sights, places, x);
        const Eigen::Vector3d X = meet(sights, places, centres, Values(sights.size(), 1.0));
        const MotionSight& first = sights.front();
        const double depth = (X - centres.front()).dot(places[first.place].R * *first.d_B);
        point.state = {0.0, 0.0, depth > 0.0 ? 1.0 / std::max(depth, kLeastDepth_m) : 0.0};
    }
}

Status MotionProblem::begin(const Places& places, bool has_scale, Unknowns& x) {
    const MotionPlace& newest = places.back();
    // Of [s v g]: s times the shape's path is the path by velocity, gravity and accelerometer.
    Form h = Form::Zero();
    Shape b = Shape::Zero();
    h.diagonal().segment<3>(1).setConstant(inverse_square(kVelocitySigma));
    h.diagonal().segment<3>(4).setConstant(inverse_square(kGravitySigma));
    b.segment<3>(4) = -newest.v / newest.t_s * inverse_square(kGravitySigma);
    if (has_scale) {
        const Form form = shape_form(places, nullptr) * inverse_square(bearing_sigma_);
        h.bottomRightCorner<6, 6>() += form.topLeftCorner<6, 6>();
        b.tail<6>() -= form.col(6).head<6>();
        h(0, 0) = 1.0;
    } else {
        Shape z = Shape::Zero();
        FACET_TRY(find_shape(places, z));
        for (const MotionPlace& place : places) {
            const ShapeCentre m = shape_centre(place, Eigen::Vector3d::Zero());
            ShapeCentre row;
            row.col(0) = m * z;
            row.rightCols<6>() = -m.leftCols<6>();
            h.noalias() += inverse_square(kPathSigma_m) * row.transpose() * row;
            b.noalias() += inverse_square(kPathSigma_m) * row.transpose() * m.col(6);
        }
    }
    const Shape found = h.ldlt().solve(b);
    x.setZero();
    x.head<6>() = found.tail<6>();
    if (!found.allFinite()) {
        return Status::kDegenerate;
    }
    place_points(places, x);
    return Status::kOk;
}

void MotionProblem::begin_at_rest(const Places& places, Unknowns& x) {
    x.setZero();
    x.segment<3>(kGravityAt) = -gravity_m_per_s2_ * places.back().v.normalized();
    place_points(places, x);
}

MotionProblem::Centre MotionProblem::d_centre_d_x(const MotionSight& sight, const MotionPlace& place) {
    Centre m;
    m.leftCols<6>() = shape_centre(place, *sight.p_B_C).leftCols<6>();
    m.middleCols<3>(kAccelBiasAt) = place.d_p_d_b.rightCols<3>();
    const Eigen::Matrix3d lever = place.R * skew(*sight.p_B_C);
    m.middleCols<3>(kGyroBiasAt) = place.d_p_d_b.leftCols<3>() - lever * place.d_theta_d_bg;
    m.col(kDelayAt) = -lever * place.d_theta_d_delay;
    return m;
}

MotionProblem::Unknowns MotionProblem::d_scale_d_x(const Places& places, const Unknowns& x) {
    const Eigen::Vector3d p_B_B = Eigen::Vector3d::Zero();
    Unknowns moment = Unknowns::Zero();
    double squares = 1e-12;
    for (std::size_t k = 0; k < places.size(); ++k) {
        const MotionSight body{nullptr, &p_B_B, k};
        const Eigen::Vector3d way = centres_of({&body, 1}, places, x).front();
        moment += d_centre_d_x(body, places[k]).transpose() * way;
        squares += way.squaredNorm();
    }
    return moment / squares;
}

MotionProblem::PointSums MotionProblem::sum(const Point& point, const Places& places, const Centres& centres,
                                            bool with_x) const {
    const Sights sights = sights_of(point);
    const MotionPlace& first = places[sights.front().place];
    const Eigen::Vector3d& d0_B = *sights.front().d_B;
    Eigen::Matrix<double, 3, 2> across;
    across.col(0) = first.R * d0_B.unitOrthogonal();
    across.col(1) = (first.R * d0_B).cross(across.col(0));
    const Eigen::Vector3d w = first.R * d0_B + across * point.state.head<2>();
    const double rho = point.state.z();
    const Centre first_centre = d_centre_d_x(sights.front(), first);
    PointSums out;
    out.pp(2, 2) = inverse_square(kInverseDepthSigma);
    out.p.z() = rho * out.pp(2, 2);
    out.cost = rho * out.p.z();
    for (std::size_t k = 0; k < sights.size(); ++k) {
        const MotionPlace& place = places[sights[k].place];
        const Eigen::Vector3d d = place.R * *sights[k].d_B;
        const Eigen::Vector3d way = centres.front() - centres[k];
        const Eigen::Vector3d ray = w + rho * way;
        const double along = std::max(d.dot(ray), kLeastDepthRatio);
        out.is_behind = out.is_behind || d.dot(ray) < kLeastDepthRatio;
        const Eigen::Vector3d e = (ray - d.dot(ray) * d) / along;
        const double error2 = e.squaredNorm() * inverse_square(bearing_sigma_);
        const double weight = inverse_square(bearing_sigma_) / (1.0 + 0.25 * error2);
        out.misfits += error2 > 9.0 ? 1 : 0;
        out.cost += 4.0 * std::log1p(0.25 * error2);
        const Eigen::Matrix3d d_e = (Eigen::Matrix3d::Identity() - (d + e) * d.transpose()) / along;
        Eigen::Matrix3d d_point;
        d_point.leftCols<2>() = d_e * across;
        d_point.col(2) = d_e * way;
        out.pp.noalias() += weight * d_point.transpose() * d_point;
        out.p.noalias() += weight * d_point.transpose() * e;
        if (with_x) {
            Centre d_ray = rho * (first_centre - d_centre_d_x(sights[k], place));
            const Eigen::Matrix3d turned = place.R * skew(place.R.transpose() * ray);
            d_ray.middleCols<3>(kGyroBiasAt) += turned * place.d_theta_d_bg;
            d_ray.col(kDelayAt) += turned * place.d_theta_d_delay;
            const Centre d_x = d_e * d_ray;
            out.px.noalias() += weight * d_point.transpose() * d_x;
            out.xx.noalias() += weight * d_x.transpose() * d_x;
            out.x.noalias() += weight * d_x.transpose() * e;
        }
    }
    return out;
}

void MotionProblem::add(Point& point, const Places& places, const Unknowns& x, Sums& sums) const {
    const Centres centres = centres_of(sights_of(point), places, x);
    for (int step = 0; step < kPointSteps; ++step) {
        const PointSums s = sum(point, places, centres, false);
        point.state -= s.pp.inverse() * s.p;
        point.state.z() = std::clamp(point.state.z(), 0.0, 1.0 / kLeastDepth_m);
    }
    const PointSums s = sum(point, places, centres, true);
    const Centre eliminated = s.pp.inverse() * s.px;
    sums.information += s.xx - s.px.transpose() * eliminated;
    sums.gradient += s.x - eliminated.transpose() * s.p;
    sums.cost += s.cost;
    ++sums.points;
    sums.behind += s.is_behind ? 1 : 0;
    sums.sightings += static_cast<int>(point.count);
    sums.misfits += s.misfits;
}

void MotionProblem::add_priors(const Places& places, const Unknowns& x, Sums& sums) const {
    Unknowns sigma;
    sigma.segment<3>(kVelocityAt).setConstant(kVelocitySigma);
    sigma.segment<3>(kGravityAt).setConstant(kGravitySigma);
    sigma.segment<6>(kAccelBiasAt) = bias_prior_.sigma;
    sigma(kDelayAt) = delay_sigma_s_;
    const Unknowns weight = sigma.cwiseAbs2().cwiseInverse();
    Unknowns off = x;
    off.segment<6>(kAccelBiasAt) -= bias_prior_.mean;
    off.segment<3>(kGravityAt) += places.back().v / places.back().t_s;  // on the mean a vehicle does not accelerate
    sums.information.diagonal() += weight;
    sums.gradient += weight.cwiseProduct(off);
    sums.cost += off.dot(weight.cwiseProduct(off));
    const double norm = x.segment<3>(kGravityAt).norm();
    const Eigen::Vector3d along = x.segment<3>(kGravityAt) / std::max(norm, 1e-3);
    sums.information.block<3, 3>(kGravityAt, kGravityAt) +=
        inverse_square(kGravityNormSigma) * along * along.transpose();
    const double beyond = norm - gravity_m_per_s2_;
    sums.gradient.segment<3>(kGravityAt) += inverse_square(kGravityNormSigma) * beyond * along;
    sums.cost += inverse_square(kGravityNormSigma) * beyond * beyond;
}

MotionProblem::Sums MotionProblem::linearize(const Places& places, const Unknowns& x) {
    Sums sums;
    for (Point& point : points_) {
        add(point, places, x, sums);
    }
    add_priors(places, x, sums);
    return sums;
}

}  // namespace facet
