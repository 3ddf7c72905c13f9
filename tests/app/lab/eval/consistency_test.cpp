// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/consistency.h"

#include <Eigen/Cholesky>
#include <catch2/catch.hpp>
#include <cmath>

#include "app/lab/eval/report.h"
#include "app/support/rng.h"
#include "tests/support/input_error_text.h"
#include "tests/support/temp_dir.h"

namespace facet::consistency_test {
namespace {

using Eigen::Vector3d;

constexpr std::int64_t kBegin = 1'400'000'000'000'000'000;
constexpr std::int64_t kStep = 50'000'000;

Eigen::Quaterniond turn(double angle, const Vector3d& axis) {
    return Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis.normalized()));
}

GroundTruthState truth_at(int i) {
    const double t = 0.05 * i;
    GroundTruthState s;
    s.stamp = {kBegin + i * kStep};
    s.q_W_B = turn(0.3 * t, {0.2, -0.1, 1.0});
    s.p_W_B = {std::cos(t), 2.0 * std::sin(0.7 * t), 0.2 * t};
    s.has_motion = true;
    s.v_W_B = {-std::sin(t), 1.4 * std::cos(0.7 * t), 0.2};
    return s;
}

std::vector<GroundTruthState> truth(int count) {
    std::vector<GroundTruthState> states;
    for (int i = 0; i < count; ++i) {
        states.push_back(truth_at(i));
    }
    return states;
}

/// A full covariance with very different scales and strong correlations.
ClaimMatrix claim() {
    RandomStream random(3, 1);
    ClaimMatrix a;
    for (int i = 0; i < kClaimDim; ++i) {
        for (int j = 0; j < kClaimDim; ++j) {
            a(i, j) = (i == j ? 2.0 : 0.0) + random.normal();
        }
    }
    ClaimVector scale;
    scale << 1e-3, 1e-3, 3e-3, 1e-2, 2e-2, 1e-2, 5e-3, 5e-3, 5e-3;
    return scale.asDiagonal() * (a * a.transpose()) * scale.asDiagonal();
}

/// Estimates in a world that is turned by yaw and shifted. All but the first have errors drawn from `covariance` times
/// factor^2.
std::vector<UncertainState> estimates(const std::vector<GroundTruthState>& truth, const ClaimMatrix& covariance,
                                      double factor) {
    RandomStream random(7, 2);
    const Eigen::LLT<ClaimMatrix> llt(covariance);
    const Se3 T_E_W{turn(1.2, Vector3d::UnitZ()), {5.0, -3.0, 1.0}};
    std::vector<UncertainState> states;
    for (const GroundTruthState& s : truth) {
        ClaimVector draw;
        for (int k = 0; k < kClaimDim; ++k) {
            draw[k] = states.empty() ? 0.0 : factor * random.normal();
        }
        const ClaimVector e = llt.matrixL() * draw;
        UncertainState state;
        state.stamp = s.stamp;
        state.T_W_B = T_E_W * Se3{s.q_W_B, s.p_W_B};
        // Tilt at the gauge stamp leaves its yaw alone; errors are of the estimate, [theta p v] leads back to
        // the truth.
        state.T_W_B.q = (state.T_W_B.q * so3_exp(Vector3d(-e.head<3>()))).normalized();
        state.T_W_B.p -= e.segment<3>(3);
        state.v_W_B = T_E_W.q * s.v_W_B - e.tail<3>();
        state.covariance = covariance;
        states.push_back(state);
    }
    return states;
}

TEST_CASE("errors drawn from the reported covariance have the NEES of a consistent estimator, in any gauge") {
    const auto states = truth(4001);
    const Consistency c = evaluate_consistency(states, estimates(states, claim(), 1.0));
    CHECK(c.gauge_stamp.ns == kBegin);
    REQUIRE(c.samples.size() == 4000);
    CHECK(c.unusable == 0);
    for (std::size_t k = 0; k < kClaimPartCount; ++k) {
        INFO(kClaimParts[k].name);
        const NeesStatistics& s = c.parts[k];
        CHECK(s.count == 4000);
        // The mean of n chi-square values of dof d has the standard deviation sqrt(2 d / n): here at most 0.055.
        CHECK(s.mean == Approx(kClaimParts[k].size).margin(0.17));
        CHECK(s.inside_95 == Approx(0.95).margin(0.012));
        CHECK(s.above_95 == Approx(0.025).margin(0.01));
        CHECK(s.within_3_sigma == Approx(0.9973).margin(0.003));
    }
}

TEST_CASE("a first state that is known to be wrong does not speak against the later ones") {
    const auto states = truth(1001);
    auto estimate = estimates(states, claim(), 1.0);
    for (int i = 0; i < 20; ++i) {  // 0.4 m off by up to 8 sigma of the claim of the others, and claimed so
        estimate[static_cast<std::size_t>(i)].T_W_B.p.y() += 0.02 * (20 - i);
        estimate[static_cast<std::size_t>(i)].covariance(4, 4) += std::pow(0.02 * (20 - i), 2);
    }
    estimate[20].T_W_B = Se3{turn(1.2, Vector3d::UnitZ()), {5.0, -3.0, 1.0}} * Se3{states[20].q_W_B, states[20].p_W_B};
    const Consistency c = evaluate_consistency(states, estimate);
    CHECK(c.gauge_stamp.ns == states[20].stamp.ns);
    CHECK(c.samples.size() == 1000);
    for (std::size_t k = 0; k < kClaimPartCount; ++k) {
        INFO(kClaimParts[k].name);
        CHECK(c.parts[k].mean == Approx(kClaimParts[k].size).epsilon(0.1));
    }
}

TEST_CASE("overconfidence and excess of caution show") {
    const auto states = truth(1001);
    const Consistency bold = evaluate_consistency(states, estimates(states, claim(), 2.0));
    const Consistency shy = evaluate_consistency(states, estimates(states, claim(), 0.25));
    for (std::size_t k = 0; k < kClaimPartCount; ++k) {
        INFO(kClaimParts[k].name);
        CHECK(bold.parts[k].mean == Approx(4.0 * kClaimParts[k].size).epsilon(0.15));
        CHECK(bold.parts[k].above_95 > 0.4);
        CHECK(shy.parts[k].mean == Approx(kClaimParts[k].size / 16.0).epsilon(0.15));
        CHECK(shy.parts[k].above_95 == 0.0);
        CHECK(shy.parts[k].inside_95 < 0.7);
    }
}

TEST_CASE("the error turns the estimate into the truth, in units and frames of the covariance") {
    const auto states = truth(3);
    auto estimate = estimates(states, ClaimMatrix::Identity(), 0.0);
    const Se3 T = estimate[1].T_W_B;
    estimate[1].T_W_B.q = T.q * so3_exp(Vector3d(0.01, 0.02, -0.03));
    estimate[1].T_W_B.p += Vector3d(0.1, 0.2, 0.3);
    estimate[1].v_W_B += Vector3d(1.0, 0.0, -1.0);
    estimate[1].covariance(4, 4) = 4.0;
    const Consistency c = evaluate_consistency(states, estimate);
    ClaimVector expected;
    expected << -0.01, -0.02, 0.03, -0.1, -0.2, -0.3, -1.0, 0.0, 1.0;
    CHECK((c.samples[0].error - expected).norm() < 1e-9);
    CHECK(c.samples[0].sigma[4] == 2.0);
    CHECK(c.samples[0].nees[1] == Approx(0.0014));
    CHECK(c.samples[0].nees[2] == Approx(0.01 + 0.01 + 0.09));
    CHECK(c.samples[0].nees[3] == Approx(2.0));
    CHECK(c.samples[1].error.norm() < 1e-9);
}

TEST_CASE("unusable covariances and missing truth are left out and counted") {
    auto states = truth(10);
    auto estimate = estimates(states, claim(), 1.0);
    estimate[3].covariance.setZero();
    estimate[4].covariance(3, 3) = std::nan("");
    estimate[5].covariance.topLeftCorner<6, 6>().setOnes();
    estimate[9].stamp.ns += 1;  // beyond the truth
    states[7].has_motion = false;
    const Consistency c = evaluate_consistency(states, estimate);
    CHECK(c.samples.size() == 8);
    CHECK(c.unusable == 3);
    CHECK(c.parts[0].count == 5);
    CHECK(c.parts[3].count == 6);  // the third's is zero as well, and one has no true velocity
    CHECK(evaluate_consistency({}, estimate).samples.empty());
}

TEST_CASE("the band holds 95 % of chi-square") {
    for (const int dof : {3, 6}) {
        const ChiSquareBand band = chi_square_band(dof);
        const auto cdf = [&](double x) {  // midpoint rule
            const int n = 20000;
            double sum = 0.0;
            for (int i = 0; i < n; ++i) {
                const double y = (i + 0.5) * x / n;
                sum += std::pow(y, 0.5 * dof - 1.0) * std::exp(-0.5 * y) * x / n;
            }
            return sum / (std::pow(2.0, 0.5 * dof) * std::tgamma(0.5 * dof));
        };
        CHECK(cdf(band.low) == Approx(0.025).margin(1e-4));
        CHECK(cdf(band.high) == Approx(0.975).margin(1e-4));
    }
}

TEST_CASE("files are joined by stamp, and wrong ones named") {
    const test::TempDir dir;
    const auto row = [](std::int64_t ns, double p) {
        return std::to_string(ns) + "," + std::to_string(p) + ",0,0,1,0,0,0,0.5,0,0,0,0,0,0,0,0\n";
    };
    const auto entries = [](int count) {
        std::string text;
        for (int i = 0; i < count; ++i) {
            text += "," + std::to_string(i + 1);
        }
        return text + "\n";
    };
    const std::string trajectory = dir.write("t.csv", "#header\n" + row(100, 1.0) + row(200, 2.0) + row(300, 3.0));
    const std::string covariance =
        dir.write("c.csv", "stamp_ns,c00\n200" + entries(45) + "300" + entries(45) + "400" + entries(45));
    const auto states = read_uncertain_states(trajectory, covariance);
    REQUIRE(states.size() == 2);
    CHECK(states[0].stamp.ns == 200);
    CHECK(states[0].T_W_B.p.x() == 2.0);
    CHECK(states[0].v_W_B.x() == 0.5);
    CHECK(states[0].covariance(0, 8) == 9.0);
    CHECK(states[0].covariance(1, 1) == 10.0);
    CHECK(states[0].covariance(8, 8) == 45.0);
    CHECK(states[0].covariance == states[0].covariance.transpose());
    const auto complaint = [&](const std::string& text) {
        return test::input_error_text([&] { read_uncertain_states(trajectory, dir.write("bad.csv", text)); });
    };
    CHECK(complaint("stamp_ns,c00\n200" + entries(44)) == dir.file("bad.csv") + ":2: row has 45 columns, not 46");
    CHECK(complaint("x" + entries(45)) == dir.file("bad.csv") + ":1: stamp is not an integer (ns)");
    CHECK(test::input_error_text([&] { read_uncertain_states(trajectory, dir.file("no.csv")); }) ==
          dir.file("no.csv") + ": cannot be read");
}

TEST_CASE("the reports and the table of errors have the figures") {
    const test::TempDir dir;
    const auto states = truth(101);
    const Consistency c = evaluate_consistency(states, estimates(states, claim(), 1.0));
    const std::string text = text_report(Claims{c, std::nullopt});
    INFO(text);
    CHECK(text.find("orientation") != std::string::npos);
    CHECK(text.find("100 samples") != std::string::npos);
    write_errors(c, dir.file("errors.csv"));
    const std::string table = test::read_file(dir.file("errors.csv"));
    CHECK(std::count(table.begin(), table.end(), '\n') == 101);
    CHECK(table.starts_with("stamp_ns,error_theta_x,"));
    const std::string first = table.substr(0, table.find('\n'));
    CHECK(std::count(first.begin(), first.end(), ',') == 22);
    CHECK(first.ends_with(",nees_pose,nees_orientation,nees_position,nees_velocity"));
}

}  // namespace
}  // namespace facet::consistency_test
