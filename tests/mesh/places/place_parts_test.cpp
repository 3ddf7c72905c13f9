// SPDX-License-Identifier: BSD-2-Clause
#include <catch2/catch.hpp>
#include <memory>
#include <random>

#include "mesh/places/correction_votes.h"
#include "mesh/places/patch_search.h"
#include "mesh/places/place_alignment.h"
#include "mesh/places/place_pose.h"
#include "tests/mesh/places/textured_room.h"

namespace facet::place_parts_test {
namespace {

using test::looking;
using test::TexturedRoom;

ImagePyramid pyramid_of(const test::SceneImage& image) {
    ImagePyramid pyramid;
    REQUIRE(ok(pyramid.configure(test::kSceneWidth, test::kSceneHeight, kPlaceLevels)));
    pyramid.build(image.view());
    return pyramid;
}

/// What a camera at a pose knows of the room's points: all of them, in order of their index.
struct Outlook {
    ImagePyramid pyramid;
    PlaceView view;
    std::vector<std::size_t> index;  ///< of each point in the room

    Outlook(const TexturedRoom& room, const Se3& T_W_C) : pyramid(pyramid_of(room.draw(T_W_C))) {
        view.q_G_C = T_W_C.q.cast<float>();
        for (std::size_t i = 0; i < room.points().size() && !view.points.full(); ++i) {
            const Eigen::Vector3d p_C = T_W_C.inverse() * room.points()[i];
            UprightSquare square;
            PlacePoint point;
            point.p_G = (room.points()[i] - T_W_C.p).cast<float>();
            point.depth_sigma = 0.01F;
            if (p_C.z() > 0.3 && ok(upright_square(room.camera(), p_C, down(T_W_C), square)) &&
                room.camera().in_image(square.centre, 2.0) && ok(describe(pyramid, square, point.code, point.patch))) {
                view.points.push_back(point);
                index.push_back(i);
            }
        }
    }
    static Eigen::Vector3d down(const Se3& T_W_C) { return T_W_C.q.conjugate() * -Eigen::Vector3d::UnitZ(); }
};

}  // namespace

TEST_CASE("poses with a known vertical compose and invert as rigid transforms do") {
    const YawPose a{0.7, {1.0, -2.0, 0.5}};
    const YawPose b{-2.9, {0.3, 0.4, -1.0}};
    const Eigen::Vector3d x(0.2, -0.6, 1.1);
    CHECK(((a * b) * x - a * (b * x)).norm() < 1e-12);
    CHECK((a.inverse() * (a * x) - x).norm() < 1e-12);
    CHECK((a.se3() * x - a * x).norm() < 1e-12);
    const YawPose::Tangent d = a.box_minus_to(b);
    CHECK(a.box_plus(d).box_minus_to(b).norm() < 1e-12);

    // carried_by() is the derivative of a composition by its first factor.
    const YawPose::Tangent step(1e-6, -2e-6, 3e-6, 1e-6);
    const YawPose::Tangent moved = (a * b).box_minus_to(a.box_plus(step) * b);
    CHECK((moved - carried_by((a * b).p - a.p) * step).norm() < 1e-11);

    const Eigen::Matrix3d tilted = Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX()).toRotationMatrix();
    CHECK(yaw_between(tilted, yaw_matrix(0.3) * tilted) == Approx(0.3));
}

TEST_CASE("a code is the same from nearer, from the side and with a rolled camera, and differs between points") {
    const TexturedRoom room;
    const Outlook far(room, looking({0.0, 0.0, 0.0}, 0.0));
    Se3 rolled = looking({1.2, 0.4, 0.1}, 0.15);
    rolled.q = rolled.q * Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()));
    const Outlook near(room, rolled);
    int same = 0;
    int compared = 0;
    double others = 0.0;
    int pairs = 0;
    for (std::size_t i = 0; i < far.index.size(); ++i) {
        for (std::size_t j = 0; j < near.index.size(); ++j) {
            const int d = far.view.points[i].code.distance_to(near.view.points[j].code);
            if (d == PointCode::kIncomparable) {
                continue;
            }
            if (far.index[i] == near.index[j]) {
                ++compared;
                same += d < 80 ? 1 : 0;
            } else {
                ++pairs;
                others += d;
            }
        }
    }
    REQUIRE(compared > 15);
    CHECK(same > 0.85 * compared);
    CHECK(others / pairs == Approx(128.0).margin(15.0));
}

TEST_CASE("a point near the vertical through the camera, or behind it, has no square") {
    const CameraModel camera = test::scene_rig().left;
    UprightSquare square;
    const Eigen::Vector3d down(0.0, 0.0, 1.0);  // a camera that looks down
    CHECK(upright_square(camera, {0.1, 0.0, 2.0}, down, square) == Status::kDegenerate);
    CHECK(upright_square(camera, {0.0, 0.0, -2.0}, Eigen::Vector3d::UnitY(), square) == Status::kDegenerate);
    CHECK(ok(upright_square(camera, {1.0, 0.0, 2.0}, down, square)));
    CHECK(square.down.x() == Approx(-1.0));  // towards what lies below
}

TEST_CASE("a patch is found to a tenth of a pixel, and not where another one is") {
    const TexturedRoom room;
    const Outlook first(room, looking({0.0, 0.0, 0.0}, 0.0));
    const Se3 T_W_C = looking({0.3, 0.1, 0.05}, 0.05);
    const ImagePyramid now = pyramid_of(room.draw(T_W_C));
    int found = 0;
    int close = 0;
    int wrong = 0;
    for (std::size_t i = 0; i + 1 < first.index.size(); ++i) {
        UprightSquare square;
        const Eigen::Vector3d p_C = T_W_C.inverse() * room.points()[first.index[i]];
        if (!ok(upright_square(room.camera(), p_C, Outlook::down(T_W_C), square))) {
            continue;
        }
        const Eigen::Vector2d truth = square.centre;
        square.centre += Eigen::Vector2d(1.2, -0.9);
        const PlacePoint& point = first.view.points[i];
        Eigen::Vector2d uv;
        if (ok(search_patch(now, square, point.code.octave, point.patch, uv))) {
            ++found;
            close += (uv - truth).norm() < 0.2 ? 1 : 0;
        }
        const PlacePoint& other = first.view.points[i + 1];
        wrong += ok(search_patch(now, square, other.code.octave, other.patch, uv)) ? 1 : 0;
    }
    REQUIRE(found > 40);
    CHECK(close > 0.8 * found);
    CHECK(wrong < 0.1 * found);
}

TEST_CASE("a view is placed in another to millimetres, with an honest covariance") {
    const TexturedRoom room;
    const Outlook known(room, looking({0.0, 0.0, 0.0}, 0.0));
    double squares = 0.0;
    int count = 0;
    for (int i = 0; i < 8; ++i) {
        const Se3 T_W_C = looking({0.1 * i - 0.3, 0.35 - 0.1 * i, 0.05 * i - 0.2}, 0.04 * i - 0.16);
        const Outlook seen(room, T_W_C);
        PointMatches matches;
        match_points({seen.view.points.data(), seen.view.points.size()},
                     {known.view.points.data(), known.view.points.size()}, matches);
        REQUIRE(is_promising(matches));
        PlacePose pose;
        REQUIRE(ok(find_pose(seen.view, known.view, matches, room.camera().focal_px(), 1, pose)));
        CHECK((pose.T_K_G.p - T_W_C.p).norm() < 0.05);
        REQUIRE(ok(align_place(seen.pyramid, room.camera(), seen.view, known.view, matches, pose)));
        const YawPose::Tangent error = YawPose{0.0, T_W_C.p}.box_minus_to(pose.T_K_G);
        CHECK(error.tail<3>().norm() < 0.01);
        CHECK(std::abs(error[0]) < 0.003);
        squares += error.dot(pose.covariance.inverse() * error);
        ++count;
    }
    CHECK(squares / count < 12.0);  // of four degrees of freedom
}

TEST_CASE("views of different rooms do not match") {
    const TexturedRoom here(1);
    const TexturedRoom there(2);
    const Outlook known(here, looking({0.0, 0.0, 0.0}, 0.0));
    int promising = 0;
    for (int i = 0; i < 6; ++i) {
        const Outlook seen(there, looking({0.2 * i - 0.5, 0.0, 0.0}, 0.5 * i));
        PointMatches matches;
        match_points({seen.view.points.data(), seen.view.points.size()},
                     {known.view.points.data(), known.view.points.size()}, matches);
        PlacePose pose;
        CHECK(!ok(find_pose(seen.view, known.view, matches, here.camera().focal_px(), 1, pose)));
        promising += is_promising(matches) ? 1 : 0;
    }
    CHECK(promising <= 2);
}

TEST_CASE("matches that agree by chance make no pose") {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> place(-3.0F, 3.0F);
    PlaceView seen;
    PlaceView known;
    seen.q_G_C = known.q_G_C = looking({0.0, 0.0, 0.0}, 0.0).q.cast<float>();
    PointMatches matches;
    for (std::uint16_t i = 0; i < 100; ++i) {
        PlacePoint a;
        PlacePoint b;
        a.p_G = Eigen::Vector3f(4.0F, place(random), place(random));
        b.p_G = Eigen::Vector3f(4.0F, place(random), place(random));
        a.depth_sigma = b.depth_sigma = 0.02F;
        seen.points.push_back(a);
        known.points.push_back(b);
        matches.push_back({i, i});
    }
    PlacePose pose;
    CHECK(find_pose(seen, known, matches, 240.0, 1, pose) == Status::kDegenerate);
}

TEST_CASE("a correction is believed after three stations, and not while a twin has as much to show") {
    const YawPose here{0.1, {1.0, 0.0, 0.0}};
    const YawPose twin{0.1, {7.0, 0.0, 0.0}};
    CorrectionVotes votes;
    for (std::uint32_t station = 1; station <= 5; ++station) {
        const YawPose T_O_G{0.0, {0.3 * station, 0.0, 0.0}};
        votes.add(station, T_O_G, twin * T_O_G, 30);
        votes.add(station, T_O_G, here * T_O_G, 32);
        CHECK(!votes.is_settled(3));
    }
    for (std::uint32_t station = 6; station <= 12; ++station) {  // only one of them has this
        const YawPose T_O_G{0.0, {0.3 * station, 0.0, 0.0}};
        votes.add(station, T_O_G, here * T_O_G, 40);
    }
    REQUIRE(votes.is_settled(3));
    CHECK(votes.T_M_O().box_minus_to(here).norm() < 1e-9);

    votes.clear();
    CHECK(!votes.is_settled(3));
    votes.add(1, {}, here, 50);
    votes.add(1, {}, here, 50);  // the same station again
    votes.add(2, {}, here, 50);
    CHECK(!votes.is_settled(3));
    votes.add(3, {}, here, 50);
    CHECK(votes.is_settled(3));
}

}  // namespace facet::place_parts_test
