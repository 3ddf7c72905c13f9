// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/evaluation.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "app/lab/eval/report.h"

namespace facet::evaluation_test {
namespace {

constexpr double kDeg = std::numbers::pi / 180.0;

Timestamp at(double seconds) {
    return {1'400'000'000'000'000'000 + static_cast<std::int64_t>(std::llround(seconds * 1e9))};
}

Eigen::Quaterniond turn(double angle, const Eigen::Vector3d& axis) {
    return Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis.normalized()));
}

/// A winding flight, 20 Hz.
Trajectory flight(double seconds) {
    Trajectory t;
    for (int i = 0; i <= static_cast<int>(20 * seconds); ++i) {
        const double s = 0.05 * i;
        t.push_back({at(s),
                     {turn(0.4 * s, {0.1, 0.2, 1.0}),
                      {2.0 * std::cos(0.5 * s), 1.5 * std::sin(0.7 * s), 0.3 * std::sin(0.9 * s)}}});
    }
    return t;
}

Trajectory moved(const Se3& T, const Trajectory& trajectory) {
    Trajectory result = trajectory;
    for (StampedPose& pose : result) {
        pose.T_W_B = T * pose.T_W_B;
    }
    return result;
}

/// A straight flight along x at 1 m/s, 20 Hz, without turning.
Trajectory straight(double seconds, double scale = 1.0) {
    Trajectory t;
    for (int i = 0; i <= static_cast<int>(20 * seconds); ++i) {
        t.push_back({at(0.05 * i), {Eigen::Quaterniond::Identity(), {scale * 0.05 * i, 0, 0}}});
    }
    return t;
}

TEST_CASE("an estimate in another world has no error after SE(3) alignment") {
    const Trajectory truth = flight(20);
    const Se3 T{turn(1.1, {1, -2, 3}), {4, 5, 6}};
    const Evaluation e = evaluate(truth, moved(T, truth), {}, {});
    CHECK(e.matched == truth.size());
    CHECK(e.se3.translation_m.max < 1e-12);
    CHECK(e.se3.rotation_deg.max < 1e-6);
    CHECK(e.scale == Approx(1.0).margin(1e-12));
    CHECK(e.end_drift_m < 1e-12);
    for (const RelativeError& r : e.relative) {
        CHECK(r.translation_m.count > 0);
        CHECK(r.translation_m.max < 1e-12);
        CHECK(r.rotation_deg.max < 1e-6);
    }
    // Tilted worlds cannot be aligned by yaw alone.
    CHECK(e.yaw4.translation_m.rmse > 0.1);
    const Se3 undone = e.se3.T_true_est * T;
    CHECK(undone.p.norm() < 1e-12);
    CHECK(so3_log(undone.q).norm() < 1e-9);
}

TEST_CASE("an estimate turned about gravity has no error after 4-DoF alignment") {
    const Trajectory truth = flight(20);
    const double yaw = GENERATE(0.0, 0.7, -2.9, 3.1);
    const Evaluation e = evaluate(truth, moved({turn(yaw, {0, 0, 1}), {1, 2, 3}}, truth), {}, {});
    CHECK(e.yaw4.translation_m.max < 1e-12);
    CHECK(e.yaw4.rotation_deg.max < 1e-6);
    CHECK(e.relative.front().yaw_deg.max < 1e-6);
}

TEST_CASE("known errors give known statistics") {
    // Errors of +-d along z, alternating and of even number, leave the alignment alone to first order in d.
    const double d = 0.01;
    const Trajectory truth = flight(20);
    Trajectory estimate = truth;
    estimate.pop_back();
    for (std::size_t i = 0; i < estimate.size(); ++i) {
        estimate[i].T_W_B.p.z() += i % 2 == 0 ? d : -d;
    }
    const Evaluation e = evaluate(truth, estimate, {}, {});
    CHECK(e.yaw4.translation_m.rmse == Approx(d).epsilon(1e-3));
    CHECK(e.yaw4.translation_m.median == Approx(d).epsilon(1e-3));
    CHECK(e.yaw4.translation_m.max == Approx(d).epsilon(1e-2));
    CHECK(e.se3.translation_m.rmse == Approx(d).epsilon(1e-2));
    CHECK(e.se3.translation_m.rmse <= e.yaw4.translation_m.rmse + 1e-12);

    const ErrorStatistics s = error_statistics({3.0, 1.0, 2.0, 10.0});
    CHECK(s.count == 4);
    CHECK(s.median == 2.5);
    CHECK(s.mean == 4.0);
    CHECK(s.rmse == Approx(std::sqrt(114.0 / 4.0)));
    CHECK(s.max == 10.0);
    CHECK(error_statistics({5.0, 1.0, 2.0}).median == 2.0);
    CHECK(error_statistics({}).count == 0);
}

TEST_CASE("scale is not aligned away, but reported") {
    const Trajectory truth = flight(20);
    Trajectory estimate = truth;
    for (StampedPose& pose : estimate) {
        pose.T_W_B.p *= 0.9;
    }
    const Evaluation e = evaluate(truth, estimate, {}, {});
    CHECK(e.scale == Approx(1.0 / 0.9).epsilon(1e-9));
    // What is left after SE(3): 0.1 of each distance to the mean position.
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const StampedPose& pose : truth) {
        mean += pose.T_W_B.p / static_cast<double>(truth.size());
    }
    double square_sum = 0.0;
    for (const StampedPose& pose : truth) {
        square_sum += 0.01 * (pose.T_W_B.p - mean).squaredNorm() / static_cast<double>(truth.size());
    }
    CHECK(e.se3.translation_m.rmse == Approx(std::sqrt(square_sum)).epsilon(1e-9));
}

TEST_CASE("a mirrored path does not align: the rotation is proper") {
    const Trajectory truth = flight(20);
    Trajectory estimate = truth;
    for (StampedPose& pose : estimate) {
        pose.T_W_B.p.x() *= -1.0;
        pose.T_W_B.p.y() *= -1.0;
        pose.T_W_B.p.z() *= -1.0;
    }
    const AbsoluteError e = absolute_error(associate(truth, estimate, Duration{1}), AlignmentMode::kSe3);
    CHECK(e.T_true_est.R().determinant() == Approx(1.0));
    CHECK(e.translation_m.rmse > 0.05);
}

TEST_CASE("relative errors of a scaled straight flight are its scale error") {
    const Trajectory truth = straight(20);
    const std::vector<PosePair> pairs = associate(truth, straight(20, 1.02), Duration{1});
    const double length = GENERATE(1.0, 5.0, 10.0);
    const RelativeError r = relative_error(pairs, length);
    CHECK(r.translation_percent.mean == Approx(2.0).epsilon(1e-9));
    CHECK(r.translation_percent.max == Approx(2.0).epsilon(1e-9));
    CHECK(r.translation_m.median == Approx(0.02 * length).epsilon(0.06));  // may overshoot by one step
    CHECK(r.rotation_deg.max < 1e-9);
    CHECK(r.translation_m.count == Approx(20.0 * (20.0 - length) + 1.0).margin(1.0));
}

TEST_CASE("relative errors of a steady yaw drift are the drift") {
    const Trajectory truth = straight(20);
    Trajectory estimate = truth;
    for (std::size_t i = 0; i < estimate.size(); ++i) {
        estimate[i].T_W_B.q = turn(0.5 * kDeg * 0.05 * static_cast<double>(i), {0, 0, 1});  // 0.5 deg a metre
    }
    const RelativeError r = relative_error(associate(truth, estimate, Duration{1}), 2.0);
    CHECK(r.rotation_deg.mean == Approx(1.0).epsilon(0.03));
    CHECK(r.rotation_deg_per_m.mean == Approx(0.5).epsilon(1e-6));
    CHECK(r.yaw_deg.mean == Approx(1.0).epsilon(0.03));
    CHECK(relative_error(associate(truth, estimate, Duration{1}), 25.0).translation_m.count == 0);
}

TEST_CASE("a roll error is a rotation error but no yaw error") {
    const Trajectory truth = straight(20);
    Trajectory estimate = truth;
    for (std::size_t i = 0; i < estimate.size(); ++i) {
        estimate[i].T_W_B.q = turn(0.5 * kDeg * 0.05 * static_cast<double>(i), {1, 0, 0});
    }
    const RelativeError r = relative_error(associate(truth, estimate, Duration{1}), 2.0);
    CHECK(r.rotation_deg.mean == Approx(1.0).epsilon(0.03));
    CHECK(r.yaw_deg.max < 1e-9);
}

TEST_CASE("end drift is the last position's error once the first poses are equal") {
    const Trajectory truth = straight(10);
    Trajectory estimate = straight(10, 1.01);
    for (StampedPose& pose : estimate) {
        pose.T_W_B.p += Eigen::Vector3d(7, 8, 9);
    }
    const Evaluation e = evaluate(truth, estimate, {}, {});
    CHECK(e.path_m == Approx(10.0));
    CHECK(e.end_drift_m == Approx(0.1));
    CHECK(e.drift_percent() == Approx(1.0));
    CHECK(e.duration_s == Approx(10.0));
}

TEST_CASE("coverage counts time and frames") {
    const Trajectory truth = straight(20);
    std::vector<Timestamp> frames;  // the camera runs from 5 s to 20 s
    for (int i = 0; i <= 300; ++i) {
        frames.push_back(at(5.0 + 0.05 * i));
    }
    Trajectory estimate(truth.begin() + 130, truth.end());  // from 6.5 s
    estimate.erase(estimate.begin() + 50, estimate.begin() + 100);
    const Coverage c = coverage(truth, estimate, frames);
    CHECK(c.truth_span == Approx(13.5 / 20.0));
    CHECK(c.time == Approx(13.5 / 15.0));
    CHECK(c.has_frames);
    CHECK(c.frames == 301);
    CHECK(c.frames_matched == 271 - 50);
    const Coverage without = coverage(truth, estimate, {});
    CHECK_FALSE(without.has_frames);
    CHECK(without.time == without.truth_span);
    CHECK(coverage(truth, {}, frames).time == 0.0);
}

TEST_CASE("degenerate input gives finite, honest answers") {
    const Trajectory truth = straight(2);
    CHECK(evaluate(truth, {}, {}, {}).matched == 0);
    CHECK(evaluate({}, truth, {}, {}).matched == 0);
    const Trajectory one{truth[3]};
    const Evaluation e = evaluate(truth, one, {}, {});
    CHECK(e.matched == 1);
    CHECK(e.se3.translation_m.rmse < 1e-12);
    CHECK(e.scale == 1.0);
    Trajectory still = truth;
    for (StampedPose& pose : still) {
        pose.T_W_B.p.setZero();
    }
    const Evaluation s = evaluate(still, still, {}, {});
    CHECK(s.se3.translation_m.max < 1e-12);
    CHECK(s.drift_percent() == 0.0);
}

TEST_CASE("both reports name the alignment and carry the same figures") {
    const Trajectory truth = flight(20);
    const Evaluation e = evaluate(truth, moved({turn(0.3, {0, 0, 1}), {1, 0, 0}}, truth), {}, {});
    const std::string text = text_report(e);
    CHECK(text.find("alignment SE(3), no scale") != std::string::npos);
    CHECK(text.find("alignment 4-DoF (yaw + translation), no scale") != std::string::npos);
    const auto json = nlohmann::json::parse(json_report(e, "gt", "est"));
    CHECK(json["ate_se3"]["alignment"] == "SE(3), no scale");
    CHECK(json["ate_se3"]["translation_m"]["rmse"].get<double>() == e.se3.translation_m.rmse);
    CHECK(json["matched"].get<std::size_t>() == e.matched);
    CHECK(json["rpe"].size() == 4);
    CHECK(json["coverage"]["time"].get<double>() == 1.0);

    const auto empty = nlohmann::json::parse(json_report(evaluate(truth, {}, {}, {}), "gt", "est"));
    CHECK(empty["ate_se3"]["translation_m"].is_null());
    CHECK(text_report(evaluate(truth, {}, {}, {})).find("no estimate matches") != std::string::npos);
}

}  // namespace
}  // namespace facet::evaluation_test
