// SPDX-License-Identifier: BSD-2-Clause
// The prior's globals: planes that come and go.
#include "estimator/factors/prior_factor.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <memory>
#include <random>

namespace facet::prior_factor_test {
namespace {

Eigen::MatrixXd random_matrix(int rows, int cols, std::mt19937& generator) {
    std::normal_distribution<double> normal;
    return Eigen::MatrixXd::NullaryExpr(rows, cols, [&] { return normal(generator); });
}

std::unique_ptr<PriorFactor> random_prior(int keyframes, int globals, std::mt19937& generator) {
    auto prior = std::make_unique<PriorFactor>();
    prior->reset(keyframes, globals);
    const Eigen::MatrixXd j = random_matrix(2 * prior->dim(), prior->dim(), generator);
    prior->h() = j.transpose() * j;
    prior->g() = random_matrix(prior->dim(), 1, generator);
    return prior;
}

}  // namespace

TEST_CASE("prior: new globals are unknown to it and change nothing else", "[prior]") {
    std::mt19937 generator(3);
    const auto prior = random_prior(2, 4, generator);
    const Eigen::MatrixXd h = prior->h();
    const Eigen::VectorXd g = prior->g();
    prior->append_globals(3);
    REQUIRE(prior->globals() == 7);
    REQUIRE(prior->keyframes() == 2);
    const Eigen::MatrixXd h_new = prior->h();
    CHECK(h_new.middleRows(4, 3).isZero(0.0));
    CHECK(h_new.middleCols(4, 3).isZero(0.0));
    CHECK(h_new.topLeftCorner(4, 4) == h.topLeftCorner(4, 4));
    CHECK(h_new.bottomLeftCorner(30, 4) == h.bottomLeftCorner(30, 4));
    CHECK(h_new.bottomRightCorner(30, 30) == h.bottomRightCorner(30, 30));
    CHECK(prior->g().head(4) == g.head(4));
    CHECK(prior->g().segment(4, 3).isZero(0.0));
    CHECK(prior->g().tail(30) == g.tail(30));

    SECTION("and leave again without a trace") {
        prior->marginalize_plane(4);
        CHECK(Eigen::MatrixXd(prior->h()) == h);
        CHECK(Eigen::VectorXd(prior->g()) == g);
    }
}

TEST_CASE("prior: a plane leaves by the Schur complement", "[prior]") {
    std::mt19937 generator(8);
    const int first = GENERATE(0, 1, 4);
    const auto prior = random_prior(2, 7, generator);
    const int rest = prior->dim() - 3;
    Eigen::MatrixXd keep = Eigen::MatrixXd::Zero(rest, prior->dim());
    keep.topLeftCorner(first, first).setIdentity();
    keep.bottomRightCorner(rest - first, rest - first).setIdentity();
    const Eigen::MatrixXd h = prior->h();
    const Eigen::VectorXd g = prior->g();
    const Eigen::MatrixXd expected = (keep * h.inverse() * keep.transpose()).inverse();
    const Eigen::VectorXd optimum = keep * h.ldlt().solve(-g);
    prior->marginalize_plane(first);
    REQUIRE(prior->globals() == 4);
    REQUIRE(prior->dim() == rest);
    CHECK((Eigen::MatrixXd(prior->h()) - expected).cwiseAbs().maxCoeff() < 1e-8 * expected.cwiseAbs().maxCoeff());
    Eigen::VectorXd gradient(rest);
    prior->evaluate(optimum, gradient);
    CHECK(gradient.norm() < 1e-8);
}

TEST_CASE("prior: a plane held in one direction only leaves what it knows and no more", "[prior]") {
    std::mt19937 generator(9);
    const auto prior = std::make_unique<PriorFactor>();
    prior->reset(1, 3);
    const Eigen::VectorXd j = random_matrix(prior->dim(), 1, generator);  // one residual between plane and keyframe
    prior->h() = j * j.transpose();
    prior->marginalize_plane(0);
    CHECK(Eigen::MatrixXd(prior->h()).cwiseAbs().maxCoeff() < 1e-9);  // the plane was free to follow
}

TEST_CASE("prior: a global that wanders is the Schur complement over what it was before", "[prior]") {
    std::mt19937 generator(21);
    const auto prior = random_prior(2, 4, generator);
    const int dim = prior->dim();
    const Eigen::MatrixXd h = prior->h();
    const Eigen::VectorXd g = prior->g();
    const int global = GENERATE(0, 2, 3);
    constexpr double kVariance = 0.3;
    // [all, with the global as it is now | the global as it was], tied by the step
    Eigen::MatrixXd joint = Eigen::MatrixXd::Zero(dim + 1, dim + 1);
    Eigen::MatrixXd was = Eigen::MatrixXd::Zero(dim, dim + 1);
    was.leftCols(dim).setIdentity();
    was(global, global) = 0.0;
    was(global, dim) = 1.0;
    Eigen::VectorXd step = Eigen::VectorXd::Zero(dim + 1);
    step(global) = 1.0;
    step(dim) = -1.0;
    joint = was.transpose() * h * was + step * step.transpose() / kVariance;
    const Eigen::VectorXd gradient = was.transpose() * g;
    const Eigen::VectorXd coupling = joint.topRightCorner(dim, 1);
    const Eigen::MatrixXd expected_h =
        joint.topLeftCorner(dim, dim) - coupling * coupling.transpose() / joint(dim, dim);
    const Eigen::VectorXd expected_g = gradient.head(dim) - coupling * gradient(dim) / joint(dim, dim);

    prior->add_walk(global, kVariance);
    CHECK((Eigen::MatrixXd(prior->h()) - expected_h).cwiseAbs().maxCoeff() < 1e-10 * h.norm());
    CHECK((Eigen::VectorXd(prior->g()) - expected_g).cwiseAbs().maxCoeff() < 1e-10 * h.norm());
    CHECK(Eigen::MatrixXd(prior->h()).isApprox(Eigen::MatrixXd(prior->h()).transpose(), 1e-12));
    // Its variance has grown by that of the step, and no other's.
    const Eigen::MatrixXd grown = Eigen::MatrixXd(prior->h()).inverse() - h.inverse();
    CHECK(grown(global, global) == Approx(kVariance).epsilon(1e-6));
    CHECK(std::abs(grown.trace() - kVariance) < 1e-6);
}

}  // namespace facet::prior_factor_test
