// SPDX-License-Identifier: BSD-2-Clause
// Landmark elimination and the reduced solver against dense references.
#include "estimator/solver/landmark_schur.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <memory>
#include <random>
#include <vector>

namespace facet::landmark_schur_test {
namespace {

constexpr int kKeyframes = 4;

Eigen::MatrixXd random_matrix(int rows, int cols, std::mt19937& generator) {
    std::normal_distribution<double> normal;
    return Eigen::MatrixXd::NullaryExpr(rows, cols, [&] { return normal(generator); });
}

/// Rows of all measurements over [keyframe states | point].
struct Dense {
    Eigen::MatrixXd a;
    Eigen::MatrixXd b;
    Eigen::VectorXd r;
};

Dense fill(LandmarkSchur& schur, const std::vector<int>& keyframes, std::mt19937& generator) {
    const int rows = 4 * static_cast<int>(keyframes.size());
    Dense d{Eigen::MatrixXd::Zero(rows, kKeyframes * kStateDim), Eigen::MatrixXd::Zero(rows, 3),
            Eigen::VectorXd::Zero(rows)};
    schur.clear();
    for (std::size_t i = 0; i < keyframes.size(); ++i) {
        StereoLinearization& l = schur.next();
        l.has_right = true;
        l.r = random_matrix(4, 1, generator);
        const Eigen::MatrixXd d_r_d_pose = random_matrix(4, 6, generator);
        l.d_r_d_T_W_B_transposed.setZero();
        l.d_r_d_T_W_B_transposed.topRows<6>() = d_r_d_pose.transpose();
        l.d_r_d_point = random_matrix(4, 3, generator);
        const int row = 4 * static_cast<int>(i);
        d.a.block(row, keyframes[i] * kStateDim, 4, 6) = d_r_d_pose;
        d.b.middleRows(row, 4) = l.d_r_d_point;
        d.r.segment(row, 4) = l.r;
        schur.add(keyframes[i]);
    }
    return d;
}

}  // namespace

TEST_CASE("landmark elimination equals the dense Schur complement", "[landmark_schur]") {
    std::mt19937 generator(7);
    const auto schur = std::make_unique<LandmarkSchur>();
    const auto system = std::make_unique<ReducedSystem>();
    system->reset(kKeyframes);
    Eigen::MatrixXd h = Eigen::MatrixXd::Zero(system->dim(), system->dim());
    Eigen::VectorXd g = Eigen::VectorXd::Zero(system->dim());
    for (const auto& keyframes : {std::vector<int>{0, 1, 2, 3}, {1, 3}, {2}}) {
        const Dense d = fill(*schur, keyframes, generator);
        REQUIRE(ok(schur->eliminate_into(*system)));
        const Eigen::MatrixXd projector = Eigen::MatrixXd::Identity(d.r.size(), d.r.size()) -
                                          d.b * (d.b.transpose() * d.b).inverse() * d.b.transpose();
        h += d.a.transpose() * projector * d.a;
        g += d.a.transpose() * projector * d.r;
    }
    const Eigen::MatrixXd lower = system->h().triangularView<Eigen::Lower>();
    const Eigen::MatrixXd expected = h.triangularView<Eigen::Lower>();
    CHECK((lower - expected).cwiseAbs().maxCoeff() < 1e-9);
    CHECK((Eigen::VectorXd(system->g()) - g).cwiseAbs().maxCoeff() < 1e-9);
}

TEST_CASE("a system that wants the gradient alone gets the same gradient", "[landmark_schur]") {
    constexpr int kRow = 2;
    constexpr int kPlaneRow = kRow + kCameraTermsDim;
    const auto schur = std::make_unique<LandmarkSchur>();
    const auto sums = std::make_unique<CameraTermSums>();
    const auto system = std::make_unique<ReducedSystem>();
    Eigen::VectorXd g[2];
    for (const bool with_matrix : {true, false}) {
        if (with_matrix) {
            system->reset(kKeyframes, kPlaneRow + kPlaneDim);
        } else {
            system->reset_gradient(kKeyframes, kPlaneRow + kPlaneDim);
        }
        CHECK(system->has_matrix() == with_matrix);
        sums->reset(kKeyframes, kRow, with_matrix);
        std::mt19937 generator(23);
        for (int landmark = 0; landmark < 3; ++landmark) {
            schur->clear(sums.get());
            std::vector<StereoLinearization> linearizations;
            for (int k = landmark; k < kKeyframes; ++k) {
                StereoLinearization& l = schur->next();
                l.has_right = k != 2;
                l.has_cameras = true;
                l.r = random_matrix(4, 1, generator);
                l.d_r_d_point = random_matrix(4, 3, generator);
                l.d_r_d_T_W_B_transposed.setZero();
                l.d_r_d_T_W_B_transposed.topRows<6>() = random_matrix(6, 4, generator);
                l.d_r_d_left_lens_transposed = random_matrix(kLensDim, 2, generator);
                l.d_r_d_right_camera_transposed.setZero();
                l.d_r_d_right_camera_transposed.topRows<kRightCameraDim>() =
                    random_matrix(kRightCameraDim, 2, generator);
                if (!l.has_right) {
                    l.r.tail<2>().setZero();
                    l.d_r_d_point.bottomRows<2>().setZero();
                    l.d_r_d_T_W_B_transposed.rightCols<2>().setZero();
                }
                linearizations.push_back(l);
                schur->add(k);
            }
            CoplanarityLinearization plane;
            plane.r = random_matrix(1, 1, generator)(0);
            plane.d_r_d_plane = random_matrix(1, 3, generator);
            plane.d_r_d_point = random_matrix(1, 3, generator);
            schur->add_plane(kPlaneRow, plane);
            schur->bound_rho();
            const auto gradient = [&](int i, const Eigen::Vector4d& r) {
                const StereoLinearization& l = linearizations[static_cast<std::size_t>(i)];
                return StereoGradient{l.d_r_d_T_W_B_transposed.topRows<6>() * r,
                                      l.d_r_d_left_lens_transposed * r.head<2>(),
                                      l.d_r_d_right_camera_transposed.topRows<kRightCameraDim>() * r.tail<2>()};
            };
            REQUIRE(
                ok(with_matrix ? schur->eliminate_into(*system) : schur->eliminate_gradient_into(*system, gradient)));
        }
        sums->add_into(*system);
        g[with_matrix ? 0 : 1] = system->g();
    }
    CHECK(g[0].cwiseAbs().minCoeff() >= 0.0);
    CHECK(g[0].segment(kRow, kCameraTermsDim).cwiseAbs().minCoeff() > 1e-6);
    CHECK((g[0] - g[1]).cwiseAbs().maxCoeff() < 1e-12 * g[0].cwiseAbs().maxCoeff() + 1e-12);
}

TEST_CASE("landmark elimination with single cameras' parameters equals the dense Schur complement",
          "[landmark_schur]") {
    constexpr int kRow = 2;
    constexpr int kPlaneRow = kRow + kCameraTermsDim;
    std::mt19937 generator(17);
    const auto schur = std::make_unique<LandmarkSchur>();
    const auto sums = std::make_unique<CameraTermSums>();
    const auto system = std::make_unique<ReducedSystem>();
    system->reset(kKeyframes, kPlaneRow + kPlaneDim);
    sums->reset(kKeyframes, kRow, true);
    Eigen::MatrixXd h = Eigen::MatrixXd::Zero(system->dim(), system->dim());
    Eigen::VectorXd g = Eigen::VectorXd::Zero(system->dim());
    for (const bool right_too : {true, false}) {
        schur->clear(sums.get());
        Eigen::MatrixXd a = Eigen::MatrixXd::Zero(13, system->dim());
        Eigen::MatrixXd b = Eigen::MatrixXd::Zero(13, 3);
        Eigen::VectorXd r = Eigen::VectorXd::Zero(13);
        for (int i = 0; i < 3; ++i) {  // the second of three sightings has no right pixel
            StereoLinearization& l = schur->next();
            l.has_cameras = true;
            l.has_right = right_too && i != 1;
            const int rows = l.has_right ? 4 : 2;
            Eigen::MatrixXd j = Eigen::MatrixXd::Zero(4, system->dim() + 4);
            j.topRows(rows) = random_matrix(rows, system->dim() + 4, generator);
            l.r = j.col(system->dim());
            l.d_r_d_point = j.rightCols<3>();
            l.d_r_d_T_W_B_transposed.setZero();
            l.d_r_d_T_W_B_transposed.topRows<6>() = j.middleCols<6>(20).transpose();
            l.d_r_d_left_lens_transposed = j.topLeftCorner<2, kLensDim>().transpose();
            l.d_r_d_right_camera_transposed.setConstant(l.has_right ? 0.0 : 1e3);  // not to be looked at
            if (l.has_right) {
                l.d_r_d_right_camera_transposed.topRows<kRightCameraDim>() =
                    j.block<2, kRightCameraDim>(2, 0).transpose();
            }
            a.block<2, kLensDim>(4 * i, kRow) = l.d_r_d_left_lens_transposed.transpose();
            a.block<2, kRightCameraDim>(4 * i + 2, kRow + kLensDim) = j.block<2, kRightCameraDim>(2, 0);
            a.block<4, 6>(4 * i, system->offset(i + 1)) = j.middleCols<6>(20);
            b.middleRows<4>(4 * i) = l.d_r_d_point;
            r.segment<4>(4 * i) = l.r;
            schur->add(i + 1);
        }
        CoplanarityLinearization plane;
        plane.r = r(12) = 0.7;
        plane.d_r_d_plane = random_matrix(1, 3, generator);
        plane.d_r_d_point = random_matrix(1, 3, generator);
        a.block<1, kPlaneDim>(12, kPlaneRow) = plane.d_r_d_plane;
        b.row(12) = plane.d_r_d_point;
        schur->add_plane(kPlaneRow, plane);
        REQUIRE(ok(schur->eliminate_into(*system)));
        const Eigen::MatrixXd projector =
            Eigen::MatrixXd::Identity(13, 13) - b * (b.transpose() * b).inverse() * b.transpose();
        h += a.transpose() * projector * a;
        g += a.transpose() * projector * r;
    }
    sums->add_into(*system);
    const Eigen::MatrixXd lower = system->h().triangularView<Eigen::Lower>();
    const Eigen::MatrixXd expected = h.triangularView<Eigen::Lower>();
    CHECK((lower - expected).cwiseAbs().maxCoeff() < 1e-9);
    CHECK((Eigen::VectorXd(system->g()) - g).cwiseAbs().maxCoeff() < 1e-9);
}

TEST_CASE("landmark elimination with a plane equals the dense Schur complement", "[landmark_schur]") {
    constexpr int kGlobals = 7;  // one of calibration, two planes
    constexpr int kRow = 4;      // the second plane
    std::mt19937 generator(13);
    const auto schur = std::make_unique<LandmarkSchur>();
    const auto system = std::make_unique<ReducedSystem>();
    system->reset(kKeyframes, kGlobals);
    const Dense d = fill(*schur, {0, 2, 3}, generator);
    CoplanarityLinearization l;
    l.r = 0.7;
    l.d_r_d_plane = random_matrix(1, 3, generator);
    l.d_r_d_point = random_matrix(1, 3, generator);

    const int rows = static_cast<int>(d.r.size()) + 1;
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(rows, system->dim());
    a.topRightCorner(rows - 1, kKeyframes * kStateDim) = d.a;
    a.block(rows - 1, kRow, 1, 3) = l.d_r_d_plane;
    Eigen::MatrixXd b(rows, 3);
    b << d.b, l.d_r_d_point;
    Eigen::VectorXd r(rows);
    r << d.r, l.r;
    const Eigen::MatrixXd projector =
        Eigen::MatrixXd::Identity(rows, rows) - b * (b.transpose() * b).inverse() * b.transpose();

    const double variance = schur->point_variance(l.d_r_d_point);
    const double expected_variance =
        (l.d_r_d_point * (d.b.transpose() * d.b).inverse() * l.d_r_d_point.transpose())(0, 0);
    CHECK(variance == Approx(expected_variance));

    schur->add_plane(kRow, l);
    REQUIRE(ok(schur->eliminate_into(*system)));
    const Eigen::MatrixXd lower = system->h().triangularView<Eigen::Lower>();
    const Eigen::MatrixXd h = a.transpose() * projector * a;
    const Eigen::MatrixXd expected = h.triangularView<Eigen::Lower>();
    CHECK((lower - expected).cwiseAbs().maxCoeff() < 1e-9);
    CHECK((Eigen::VectorXd(system->g()) - a.transpose() * projector * r).cwiseAbs().maxCoeff() < 1e-9);
}

TEST_CASE("landmark elimination refuses a point without information", "[landmark_schur]") {
    const auto schur = std::make_unique<LandmarkSchur>();
    const auto system = std::make_unique<ReducedSystem>();
    system->reset(2);
    schur->clear();
    StereoLinearization& l = schur->next();
    l.r.setOnes();
    l.d_r_d_T_W_B_transposed.setOnes();
    l.d_r_d_point.setZero();
    schur->add(0);
    CHECK(schur->eliminate_into(*system) == Status::kDegenerate);
    CHECK(system->h().isZero(0.0));
}

TEST_CASE("reduced solver equals a dense solve, damped or not", "[reduced_system]") {
    std::mt19937 generator(11);
    const auto system = std::make_unique<ReducedSystem>();
    const auto solver = std::make_unique<ReducedSolver>();
    system->reset(kKeyframes);
    const Eigen::MatrixXd j = random_matrix(2 * system->dim(), system->dim(), generator);
    const Eigen::MatrixXd h = j.transpose() * j;
    const Eigen::VectorXd g = random_matrix(system->dim(), 1, generator);
    system->h() = h.triangularView<Eigen::Lower>();
    system->g() = g;
    for (const double lambda : {0.0, 0.1}) {
        REQUIRE(ok(solver->solve(*system, lambda)));
        Eigen::MatrixXd damped = h;
        damped.diagonal() *= 1.0 + lambda;
        const Eigen::VectorXd expected = damped.ldlt().solve(-g);
        CHECK((Eigen::VectorXd(solver->step()) - expected).norm() < 1e-9 * expected.norm());
        const double decrease = -(g.dot(expected) + 0.5 * expected.dot(h * expected));
        CHECK(solver->predicted_decrease() == Approx(decrease));
    }
    REQUIRE(ok(solver->solve(*system, 0.0)));
    const Eigen::MatrixXd covariance = h.inverse().bottomRightCorner<kStateDim, kStateDim>();
    CHECK((solver->last_keyframe_covariance() - covariance).cwiseAbs().maxCoeff() <
          1e-9 * covariance.cwiseAbs().maxCoeff());
}

TEST_CASE("reduced solver knows how uncertain the cameras' parameters are together", "[reduced_system]") {
    constexpr int kFirst = 7;
    std::mt19937 generator(12);
    const auto system = std::make_unique<ReducedSystem>();
    const auto solver = std::make_unique<ReducedSolver>();
    system->reset(kKeyframes, kFirst + kCameraTermsDim + 3);
    const Eigen::MatrixXd j = random_matrix(2 * system->dim(), system->dim(), generator);
    const Eigen::MatrixXd h = j.transpose() * j;
    system->h() = h.triangularView<Eigen::Lower>();
    REQUIRE(ok(solver->solve(*system, 0.0)));
    const Eigen::MatrixXd covariance = h.inverse().block<kCameraTermsDim, kCameraTermsDim>(kFirst, kFirst);
    CHECK((solver->cameras_covariance(kFirst) - covariance).cwiseAbs().maxCoeff() <
          1e-9 * covariance.cwiseAbs().maxCoeff());
    CHECK(solver->variance(kFirst + 2) == Approx(covariance(2, 2)));
}

TEST_CASE("reduced solver refuses an indefinite system", "[reduced_system]") {
    const auto system = std::make_unique<ReducedSystem>();
    const auto solver = std::make_unique<ReducedSolver>();
    system->reset(1);
    system->h().setIdentity();
    system->h()(3, 3) = -1.0;
    CHECK(solver->solve(*system, 0.0) == Status::kDegenerate);
}

}  // namespace facet::landmark_schur_test
