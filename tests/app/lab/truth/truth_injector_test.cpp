// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/truth/truth_injector.h"

#include <array>
#include <catch2/catch.hpp>
#include <memory>
#include <numbers>
#include <vector>

#include "tests/support/ideal_camera.h"
#include "tests/support/input_error_text.h"
#include "tests/support/temp_dir.h"

namespace facet::truth_injector_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;
constexpr double kBaseline = 0.1;
constexpr double kWall = 4.0;   // m ahead, along W's x
constexpr double kSpeed = 1.0;  // m/s, sideways along W's y

StereoRig rig() {
    StereoRig r;
    r.left = r.right = test::ideal_camera(640, 480, 400.0);
    r.T_B_C0 = test::looking_along_x();
    r.T_B_C1 = test::looking_along_x({0.0, -kBaseline, 0.0});
    return r;
}

/// A second of flight along a wall, as a dataset, with a post before the wall that hides a part of it.
void write_dataset(const test::TempDir& dir) {
    std::string table = "#t,p,q,v,bg,ba\n";
    for (int k = 0; k <= 10; ++k) {
        table += std::to_string(1'000'000'000 + k * 100'000'000) + ",0," + std::to_string(0.1 * k * kSpeed) +
                 ",0,1,0,0,0,0,1,0,0.01,0.02,0.03,0.1,0.2," + std::to_string(0.3 + 0.1 * k) + "\n";
    }
    dir.write("mav0/state_groundtruth_estimate0/data.csv", table);
    dir.write("mav0/cam0/data.csv", "");
    dir.write("truth/scene.ply",
              "ply\nformat ascii 1.0\nelement vertex 7\nproperty float x\nproperty float y\nproperty float z\n"
              "element face 3\nproperty list uchar int vertex_indices\nend_header\n"
              "4 -9 -9\n4 9 -9\n4 9 9\n4 -9 9\n2 0.9 -9\n2 1.1 -9\n2 1.0 9\n"
              "3 0 1 2\n3 0 2 3\n3 4 5 6\n");
}

Timestamp at(double seconds) { return Timestamp{} + Duration::from_seconds(1.0 + seconds); }

/// Where a camera of the rig, as true at this time, sees a point.
Vector2d seen(const Vector3d& p_W, double seconds, const Se3& T_B_C) {
    const Se3 T_W_B{Eigen::Quaterniond::Identity(), {0.0, kSpeed * seconds, 0.0}};
    return ((T_W_B * T_B_C).inverse() * p_W).hnormalized();
}

FeatureObservation observed(std::uint32_t id, const Vector2d& left, const Vector2d& right) {
    FeatureObservation o;
    o.landmark = {id};
    o.left_xy = left;
    o.right_xy = right;
    o.has_right = true;
    return o;
}

}  // namespace

TEST_CASE("true tracks stay on the point of the surface that they began on") {
    const test::TempDir dir;
    write_dataset(dir);
    TruthInjector injector(dir.path(), rig(), parse_truth("tracks"));
    const Vector3d p_W(kWall, 0.2, -0.3);
    const Vector2d noise(0.003, -0.002);
    const StereoRig r = rig();

    std::array first{observed(7, seen(p_W, 0.0, r.T_B_C0), seen(p_W, 0.0, r.T_B_C1) + noise)};
    injector.edit(at(0.0), first);
    CHECK((first[0].left_xy - seen(p_W, 0.0, r.T_B_C0)).norm() < 1e-9);  // it began there, by definition

    std::array later{observed(7, seen(p_W, 0.45, r.T_B_C0) + noise, seen(p_W, 0.45, r.T_B_C1))};
    injector.edit(at(0.45), later);  // between two rows of the ground truth
    CHECK((later[0].left_xy - seen(p_W, 0.45, r.T_B_C0)).norm() < 1e-9);
    CHECK((later[0].right_xy - (seen(p_W, 0.45, r.T_B_C1) - noise)).norm() < 1e-9);  // disparity as measured

    std::array outside{observed(7, seen(p_W, 0.45, r.T_B_C0) + noise, seen(p_W, 0.45, r.T_B_C1))};
    injector.edit(at(5.0), outside);  // the ground truth has ended
    CHECK(outside[0].left_xy == seen(p_W, 0.45, r.T_B_C0) + noise);
}

TEST_CASE("a track whose point is hidden stays as measured") {
    const test::TempDir dir;
    write_dataset(dir);
    TruthInjector injector(dir.path(), rig(), parse_truth("tracks"));
    const StereoRig r = rig();
    const Vector3d behind_post(kWall, 1.4, 0.0);  // from y = 0.6 the post, at y = 1, lies in the line of sight
    std::array first{observed(1, seen(behind_post, 0.0, r.T_B_C0), Vector2d::Zero())};
    injector.edit(at(0.0), first);
    const Vector2d measured = seen(behind_post, 0.6, r.T_B_C0) + Vector2d(0.01, 0.0);
    std::array hidden{observed(1, measured, Vector2d::Zero())};
    injector.edit(at(0.6), hidden);
    CHECK(hidden[0].left_xy == measured);
}

TEST_CASE("true stereo shows the right camera what the left pixel lies on") {
    const test::TempDir dir;
    write_dataset(dir);
    TruthInjector injector(dir.path(), rig(), parse_truth("stereo"));
    const StereoRig r = rig();
    const Vector3d p_W(kWall, 0.3, 0.1);
    std::array observations{observed(1, seen(p_W, 0.2, r.T_B_C0), {0.5, 0.5}),
                            observed(2, seen(p_W, 0.2, r.T_B_C0), {0.0, 0.0})};
    observations[1].has_right = false;
    injector.edit(at(0.2), observations);
    for (const FeatureObservation& o : observations) {
        CHECK(o.has_right);
        CHECK(o.left_xy == seen(p_W, 0.2, r.T_B_C0));
        CHECK((o.right_xy - seen(p_W, 0.2, r.T_B_C1)).norm() < 1e-9);
    }
    std::array mono{observed(3, seen(p_W, 0.2, r.T_B_C0), {0.0, 0.0})};
    mono[0].has_right = false;
    injector.edit(at(0.2), mono);  // no keyframe: the front-end looked for no right pixel at all
    CHECK_FALSE(mono[0].has_right);
}

TEST_CASE("true biases are taken out of inertial samples") {
    const test::TempDir dir;
    write_dataset(dir);
    const TruthInjector injector(dir.path(), rig(), parse_truth("bias"));
    ImuSample sample{at(0.25), {1.0, 2.0, 3.0}, {4.0, 5.0, 6.0}};
    injector.correct(sample);
    CHECK((sample.w_B - Vector3d(0.99, 1.98, 2.97)).norm() < 1e-12);
    CHECK((sample.a_B - Vector3d(3.9, 4.8, 6.0 - 0.55)).norm() < 1e-9);
    const TruthInjector without(dir.path(), rig(), parse_truth("tracks"));
    without.correct(sample);
    CHECK(sample.w_B.x() == Approx(0.99));
}

TEST_CASE(
    "true planes have the landmarks whose first sighting met them, and stand where the estimate's world has them") {
    const test::TempDir dir;
    write_dataset(dir);
    // The wall's triangles face away from the camera in the file: its normal is that of the surface.
    dir.write("truth/planes.json", R"([{"name": "ramp", "normal": [-0.6, 0, 0.8], "distance": 1},
                                        {"name": "wall", "normal": [1, 0, 0], "distance": 4}])");
    TruthInjector injector(dir.path(), rig(), parse_truth("planes"));
    const StereoRig r = rig();
    std::vector<FeatureObservation> observations;
    for (std::uint32_t i = 0; i < 8; ++i) {
        const Vector3d on_wall(kWall, -0.8 + 0.2 * i, 0.1 * (i % 3));
        observations.push_back(observed(10 + i, seen(on_wall, 0.0, r.T_B_C0), seen(on_wall, 0.0, r.T_B_C1)));
    }
    const Vector3d on_post(2.0, 1.0, -2.0);
    observations.push_back(observed(30, seen(on_post, 0.0, r.T_B_C0), seen(on_post, 0.0, r.T_B_C1)));
    injector.edit(at(0.0), observations);
    // The estimate's world is shifted by 1 m along x and turned by 90 deg about z.
    const Se3 T_est_true{Eigen::Quaterniond(Eigen::AngleAxisd(0.5 * kPi, Vector3d::UnitZ())), {1.0, 0.0, 0.0}};
    const auto view = std::make_unique<KeyframeView>();
    view->T_W_C0 = T_est_true * r.T_B_C0;  // the true body is at the origin
    const auto tell = [&](std::uint32_t id) {
        LandmarkSnapshot s;
        s.id = {id};
        view->landmarks.push_back(s);
    };
    const PlaneProposals found;
    tell(5);  // seen by no one
    for (std::uint32_t i = 0; i < 5; ++i) {
        tell(10 + i);
    }
    CHECK(injector.propose(*view, found).empty());  // too few
    tell(16);
    tell(17);
    tell(30);
    const PlaneProposals& proposals = injector.propose(*view, found);
    REQUIRE(proposals.size() == 1);
    CHECK(proposals[0].id.value == TruePlanes::kFirstId + 1);  // nothing was seen on the ramp, which is the first
    CHECK(proposals[0].kind == PlaneKind::kVertical);
    CHECK((proposals[0].normal_W - Vector3d::UnitY()).norm() < 1e-9);
    CHECK(proposals[0].distance_m == Approx(kWall));
    REQUIRE(proposals[0].landmarks.size() == 7);
    CHECK(proposals[0].landmarks.back().value == 17);
    // Without a true pose what was found stands.
    injector.edit(at(9.0), observations);
    CHECK(&injector.propose(*view, found) == &found);
}

TEST_CASE("what the truth lacks is named") {
    const test::TempDir dir;
    CHECK(parse_truth("").any() == false);
    CHECK(test::input_error_text([] { parse_truth("tracks,depth"); }) ==
          "--truth tracks,depth: must be tracks, stereo, bias and planes, with commas between");
    CHECK(test::input_error_text([&] { TruthInjector(dir.path(), rig(), parse_truth("bias")); }) ==
          "--truth: " + dir.path() + " has no ground truth");
    write_dataset(dir);
    CHECK_THAT(test::input_error_text([&] { TruthInjector(dir.path(), rig(), parse_truth("planes")); }),
               Catch::Contains("--truth planes: no plane in"));
    std::filesystem::remove(dir.file("truth/scene.ply"));
    CHECK_THAT(test::input_error_text([&] { TruthInjector(dir.path(), rig(), parse_truth("stereo")); }),
               Catch::Contains("scene.ply"));
}

}  // namespace facet::truth_injector_test
