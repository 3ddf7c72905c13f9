// SPDX-License-Identifier: BSD-2-Clause
// Camera models: round trips and Jacobians over the whole image, limits of validity.
#include "estimator/geometry/camera_model.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/support/numeric_jacobian.h"

namespace facet::camera_model_test {
namespace {

CameraIntrinsics pinhole() { return {640, 480, 400.0, 410.0, 320.5, 239.5, Distortion::kNone, {}}; }

/// A moderate wide-angle lens with barrel distortion.
CameraIntrinsics radial_tangential() {
    return {752,
            480,
            458.654,
            457.296,
            367.215,
            248.375,
            Distortion::kRadialTangential,
            {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05}};
}

/// A fisheye of nearly 190 degrees across a 512 pixel image.
CameraIntrinsics equidistant() {
    return {512,
            512,
            190.978,
            190.973,
            254.932,
            256.897,
            Distortion::kEquidistant,
            {0.0034824, 0.00071502, -0.0020532, 0.00020294}};
}

CameraIntrinsics with_lens(Distortion distortion, double focal_px, const std::array<double, 4>& coeffs,
                           const std::array<double, 4>& more = {}) {
    return {512, 512, focal_px, 1.002 * focal_px, 254.9, 256.9, distortion, coeffs, more};
}

/// A lens of five coefficients, and one of eight as depth cameras have.
CameraIntrinsics plumb_bob() {
    CameraIntrinsics k = radial_tangential();
    k.distortion = Distortion::kRational;
    k.more = {0.004, 0.0, 0.0, 0.0};
    return k;
}
CameraIntrinsics rational() {
    return with_lens(Distortion::kRational, 252.0, {4.84, 2.93, 1.7e-4, -6e-5}, {0.13, 5.17, 4.61, 0.73});
}
CameraIntrinsics unified() {
    return with_lens(Distortion::kUnified, 390.0, {-0.12, 0.21, 4e-4, -3e-4}, {1.02, 0.0, 0.0, 0.0});
}
CameraIntrinsics double_sphere() { return with_lens(Distortion::kDoubleSphere, 157.3, {-0.18, 0.59, 0.0, 0.0}); }
CameraIntrinsics eucm() { return with_lens(Distortion::kEucm, 190.5, {0.627, 1.058, 0.0, 0.0}); }
CameraIntrinsics fov() { return with_lens(Distortion::kFov, 261.0, {0.93, 0.0, 0.0, 0.0}); }

/// One of each kind.
std::vector<CameraIntrinsics> all_lenses() {
    return {pinhole(), radial_tangential(), equidistant(), plumb_bob(), rational(),
            unified(), double_sphere(),     eucm(),        fov()};
}

/// Calls f(uv) over a grid of pixels; margin keeps it inside.
template <class Function>
void for_pixels(const CameraIntrinsics& k, double margin, const Function& f) {
    constexpr int kGrid = 12;
    for (int a = 0; a <= kGrid; ++a) {
        for (int b = 0; b <= kGrid; ++b) {
            f(Eigen::Vector2d(margin + (k.width - 1 - 2 * margin) * a / kGrid,
                              margin + (k.height - 1 - 2 * margin) * b / kGrid));
        }
    }
}

void expect_round_trip_and_jacobians(const CameraIntrinsics& k, double margin, int least_points) {
    const CameraModel camera(k);
    int points = 0;
    for_pixels(k, margin, [&](const Eigen::Vector2d& uv) {
        CAPTURE(uv.transpose());
        Eigen::Vector2d xy;
        Eigen::Matrix2d d_xy_d_uv;
        if (!ok(camera.unproject(uv, xy, &d_xy_d_uv))) {
            return;
        }
        ++points;
        for (const double depth : {0.2, 3.0}) {
            const Eigen::Vector3d p_C = depth * Eigen::Vector3d(xy.x(), xy.y(), 1.0);
            Eigen::Vector2d again;
            Eigen::Matrix<double, 2, 3> d_uv_d_p_C;
            REQUIRE(ok(camera.project(p_C, again, &d_uv_d_p_C)));
            CHECK((again - uv).norm() < 1e-7);
            const auto project = [&](const Eigen::Vector3d& p) {
                Eigen::Vector2d out;
                REQUIRE(ok(camera.project(p, out)));
                return out;
            };
            test::expect_jacobian_near(d_uv_d_p_C, project, p_C, 1e-6, 1e-6 * depth);
            // the inverse of the projection's Jacobian over the image plane
            const Eigen::Matrix2d product = d_xy_d_uv * d_uv_d_p_C.leftCols<2>() * depth;
            CHECK((product - Eigen::Matrix2d::Identity()).norm() < 1e-7);
        }
    });
    CHECK(points >= least_points);
}

}  // namespace

TEST_CASE("pinhole: closed form") {
    const CameraModel camera(pinhole());
    Eigen::Vector2d uv;
    REQUIRE(ok(camera.project({0.5, -0.25, 2.0}, uv)));
    CHECK(uv.x() == Approx(400.0 * 0.25 + 320.5));
    CHECK(uv.y() == Approx(410.0 * -0.125 + 239.5));
    CHECK(camera.focal_px() == Approx(405.0));
}

TEST_CASE("radial-tangential: closed form of one point") {
    const CameraIntrinsics k = radial_tangential();
    const double x = 0.3;
    const double y = -0.2;
    const double r2 = x * x + y * y;
    const double radial = 1.0 + k.coeffs[0] * r2 + k.coeffs[1] * r2 * r2;
    const double xd = x * radial + 2.0 * k.coeffs[2] * x * y + k.coeffs[3] * (r2 + 2.0 * x * x);
    const double yd = y * radial + k.coeffs[2] * (r2 + 2.0 * y * y) + 2.0 * k.coeffs[3] * x * y;
    Eigen::Vector2d uv;
    REQUIRE(ok(CameraModel(k).project({3.0 * x, 3.0 * y, 3.0}, uv)));
    CHECK((uv - Eigen::Vector2d(k.fx * xd + k.cx, k.fy * yd + k.cy)).norm() < 1e-10);
}

TEST_CASE("equidistant: without coefficients the image radius is the angle") {
    CameraIntrinsics k = equidistant();
    k.coeffs = {};
    const CameraModel camera(k);
    for (const double angle : {1e-6, 1e-4, 0.01, 0.5, 1.0, 1.4}) {
        Eigen::Vector2d uv;
        REQUIRE(ok(camera.project({std::sin(angle), 0.0, std::cos(angle)}, uv)));
        CHECK(uv.x() - k.cx == Approx(k.fx * angle).epsilon(1e-9));
        CHECK(uv.y() == Approx(k.cy));
    }
}

TEST_CASE("project inverts unproject, and Jacobians match, over the whole image") {
    SECTION("pinhole") { expect_round_trip_and_jacobians(pinhole(), 0.0, 169); }
    SECTION("radial-tangential") { expect_round_trip_and_jacobians(radial_tangential(), 0.0, 169); }
    SECTION("equidistant, 64 px inside: up to 80 degrees off axis") {
        expect_round_trip_and_jacobians(equidistant(), 64.0, 145);
    }
}

TEST_CASE("every lens: project inverts unproject, Jacobians match, and what is outside its set is refused") {
    for (const CameraIntrinsics& k : all_lenses()) {
        CAPTURE(static_cast<int>(k.distortion));
        REQUIRE(ok(CameraModel::validate(k)));
        const CameraModel camera(k);
        expect_round_trip_and_jacobians(k, k.distortion == Distortion::kNone ? 0.0 : 40.0, 130);
        // Rays at all angles: a pixel inside the lens's circle, or a refusal; pixels go outwards as angles grow.
        double last_radius = -1.0;
        for (double degrees = 0.0; degrees < 90.0; degrees += 1.5) {
            CAPTURE(degrees);
            const double angle = degrees * M_PI / 180.0;
            const Eigen::Vector3d ray(0.6 * std::sin(angle), -0.8 * std::sin(angle), std::cos(angle));
            Eigen::Vector2d uv;
            if (ok(camera.project(ray, uv))) {
                CHECK(std::tan(angle) <= camera.max_radius() * (1.0 + 1e-12));
                const double radius = Eigen::Vector2d((uv.x() - k.cx) / k.fx, (uv.y() - k.cy) / k.fy).norm();
                CHECK(radius > last_radius);
                last_radius = radius;
                Eigen::Vector2d again;
                REQUIRE(ok(camera.unproject(uv, again)));
                const Eigen::Vector2d xy = ray.hnormalized();
                CHECK((again - xy).norm() < 1e-7 * (1.0 + xy.squaredNorm()));
            } else {
                CHECK(std::tan(angle) > camera.max_radius());
            }
        }
        // On the axis a normalised residual is that many pixels.
        CHECK(camera.focal_px() == Approx(camera.d_uv_d_xy({0.0, 0.0}).trace() / 2.0));
    }
}

TEST_CASE("lenses of other models that are the same lens project alike") {
    // Without coefficients of its own each is a pinhole; a unified lens at xi = 1 and a double sphere with no second
    // sphere are one with eucm; at xi = 1 it is stereographic: r s = tan(angle / 2).
    const CameraModel plain(with_lens(Distortion::kNone, 300.0, {}));
    const CameraModel four(radial_tangential());
    CameraIntrinsics k = radial_tangential();
    k.distortion = Distortion::kRational;
    const CameraModel eight(k);
    k.distortion = Distortion::kUnified;
    const CameraModel no_mirror(k);
    const CameraModel eucm_half(with_lens(Distortion::kEucm, 300.0, {0.5, 1.0, 0.0, 0.0}));
    const CameraModel stereographic(with_lens(Distortion::kUnified, 600.0, {}, {1.0, 0.0, 0.0, 0.0}));
    const CameraModel one_sphere(with_lens(Distortion::kDoubleSphere, 300.0, {0.0, 0.5, 0.0, 0.0}));
    const CameraModel nearly_flat(with_lens(Distortion::kFov, 300.0, {1e-5, 0.0, 0.0, 0.0}));
    for (const double angle : {0.0, 0.1, 0.4, 0.6}) {
        const Eigen::Vector3d p(std::sin(angle), 0.2 * std::sin(angle), std::cos(angle));
        const auto pixel = [&](const CameraModel& camera) {
            Eigen::Vector2d uv;
            REQUIRE(ok(camera.project(p, uv)));
            return uv;
        };
        CHECK((pixel(eight) - pixel(four)).norm() < 1e-9);
        CHECK((pixel(no_mirror) - pixel(four)).norm() < 1e-9);
        CHECK((pixel(eucm_half) - pixel(stereographic)).norm() < 1e-9);
        CHECK((pixel(one_sphere) - pixel(stereographic)).norm() < 1e-9);
        CHECK((pixel(nearly_flat) - pixel(plain)).norm() < 1e-4);
    }
    Eigen::Vector2d uv;
    REQUIRE(ok(stereographic.project({std::sin(1.2), 0.0, std::cos(1.2)}, uv)));
    CHECK(uv.x() - 254.9 == Approx(600.0 * std::tan(0.6)));
}

TEST_CASE("equidistant is smooth across the near-axis branch") {
    const CameraModel camera(equidistant());
    for (const double r : {0.0, 1e-8, 9.99e-5, 1.001e-4, 1e-3}) {
        CAPTURE(r);
        const Eigen::Vector2d xy(0.6 * r, 0.8 * r);
        Eigen::Matrix2d jacobian;
        camera.distort(xy, &jacobian);
        const auto f = [&](const Eigen::Vector2d& p) { return camera.distort(p); };
        test::expect_jacobian_near(jacobian, f, xy, 1e-9, 1e-6);
    }
}

TEST_CASE("equidistant: exact both ways up to the limit of use, refused beyond, and beyond 90 degrees") {
    const CameraIntrinsics k = equidistant();
    const CameraModel camera(k);
    const double limit = std::atan(camera.max_radius());
    CHECK(limit == Approx(84.29 * M_PI / 180.0).margin(1e-3));
    for (const double azimuth : {0.0, 0.9, 2.4, 4.0}) {
        const auto ray = [&](double angle) {
            return Eigen::Vector3d(std::sin(angle) * std::cos(azimuth), std::sin(angle) * std::sin(azimuth),
                                   std::cos(angle));
        };
        for (const double degrees : {70.0, 78.0, 80.0, 82.0, 84.0, 84.28}) {
            CAPTURE(azimuth, degrees);
            const Eigen::Vector3d p = ray(degrees * M_PI / 180.0);
            Eigen::Vector2d uv;
            Eigen::Vector2d xy;
            REQUIRE(ok(camera.project(p, uv)));
            REQUIRE(ok(camera.unproject(uv, xy)));
            CHECK((xy - p.head<2>() / p.z()).norm() < 1e-7);
            CHECK(camera.in_lens(uv, 0.0));
        }
        for (const double degrees : {84.5, 89.0, 90.0, 91.0, 120.0}) {
            CAPTURE(azimuth, degrees);
            Eigen::Vector2d uv(-7.0, -8.0);
            CHECK(camera.project(ray(degrees * M_PI / 180.0), uv) == Status::kDegenerate);
            // The pixel at which a lens without that limit would see it:
            const double theta = degrees * M_PI / 180.0;
            const Eigen::Vector2d there =
                Eigen::Vector2d(k.cx, k.cy) + k.fx * theta * Eigen::Vector2d(std::cos(azimuth), std::sin(azimuth));
            CHECK(camera.unproject(there, uv) == Status::kDegenerate);
            CHECK_FALSE(camera.in_lens(there, 0.0));
            CHECK(uv == Eigen::Vector2d(-7.0, -8.0));
        }
    }
}

TEST_CASE("equidistant: what the first derivatives leave out is bounded, in the image and in normalised coordinates") {
    CameraIntrinsics k = equidistant();
    k.coeffs = {};
    k.fy = k.fx;
    const CameraModel camera(k);
    for (const double angle : {0.3, 1.0, 1.3, 80.0 * M_PI / 180.0, 1.45}) {
        CAPTURE(angle);
        const Eigen::Vector3d p(std::sin(angle), 0.0, std::cos(angle));
        Eigen::Vector2d uv;
        Eigen::Matrix<double, 2, 3> d_uv_d_p;
        REQUIRE(ok(camera.project(p, uv, &d_uv_d_p)));
        Eigen::Vector2d xy;
        Eigen::Matrix2d d_xy_d_uv;
        REQUIRE(ok(camera.unproject(uv, xy, &d_xy_d_uv)));
        for (double turn = 0.1; turn < 6.3; turn += 0.5) {
            // A step of the ray across itself: the image bends by less than one focal length times its square.
            const double step_rad = 2e-3;
            const Eigen::Vector3d radial(std::cos(angle), 0.0, -std::sin(angle));
            const Eigen::Vector3d d = step_rad * (std::cos(turn) * radial + std::sin(turn) * Eigen::Vector3d::UnitY());
            Eigen::Vector2d moved;
            REQUIRE(ok(camera.project(p + d, moved)));
            CHECK((moved - uv - d_uv_d_p * d).norm() < 1.0 * k.fx * step_rad * step_rad);
            // A pixel back to normalised coordinates: bent by tan'' / 2 = tan (1 + tan^2), 188 at 80 degrees. A pixel
            // there is worth 33 of the centre's along the radius, known to a tenth of itself only.
            const Eigen::Vector2d pixel(0.5 * std::cos(turn), 0.5 * std::sin(turn));
            const double theta = pixel.norm() / k.fx;
            const double bend = (1.0 + xy.squaredNorm()) * (1.0 + xy.norm());
            REQUIRE(ok(camera.unproject(uv + pixel, moved)));
            CHECK((moved - xy - d_xy_d_uv * pixel).norm() < 1.2 * bend * theta * theta);
        }
    }
}

TEST_CASE("a pixel is in the lens where it can be unprojected; borders are kept") {
    for (const CameraIntrinsics& k : {pinhole(), radial_tangential(), equidistant()}) {
        const CameraModel camera(k);
        int outside = 0;
        for_pixels(k, 0.0, [&](const Eigen::Vector2d& uv) {
            Eigen::Vector2d xy;
            CHECK(camera.in_lens(uv, 0.0) == ok(camera.unproject(uv, xy)));
            outside += camera.in_lens(uv, 0.0) ? 0 : 1;
        });
        CHECK((outside > 0) == (k.distortion == Distortion::kEquidistant));
    }
    const CameraModel fisheye(equidistant());
    Eigen::Vector2d rim;
    REQUIRE(ok(fisheye.project({std::tan(1.45), 0.0, 1.0}, rim)));
    CHECK(fisheye.in_lens(rim, 2.0));
    CHECK_FALSE(fisheye.in_lens(rim, 8.0));
    CHECK_FALSE(fisheye.in_image({0.0, 0.0}, 0.0));
    CHECK_FALSE(CameraModel(pinhole()).in_lens({std::nan(""), 0.0}, 0.0));
}

TEST_CASE("the image's derivative with respect to normalised coordinates is that of the projection") {
    for (const CameraIntrinsics& k : all_lenses()) {
        const CameraModel camera(k);
        const Eigen::Vector2d xy(0.4, -0.3);
        Eigen::Vector2d uv;
        Eigen::Matrix<double, 2, 3> d_uv_d_p;
        REQUIRE(ok(camera.project(xy.homogeneous(), uv, &d_uv_d_p)));
        CHECK(camera.d_uv_d_xy(xy).isApprox(d_uv_d_p.leftCols<2>(), 1e-12));
    }
}

TEST_CASE("points behind, on, or far off the axis are degenerate and leave the output alone") {
    for (const CameraIntrinsics& k : all_lenses()) {
        const CameraModel camera(k);
        Eigen::Vector2d uv(-7.0, -8.0);
        const double nan = std::numeric_limits<double>::quiet_NaN();
        CHECK(camera.project({0.0, 0.0, -1.0}, uv) == Status::kDegenerate);
        CHECK(camera.project({0.0, 0.0, 0.0}, uv) == Status::kDegenerate);
        CHECK(camera.project({100.0, 0.0, 1.0}, uv) == Status::kDegenerate);
        CHECK(camera.project({nan, 0.0, 1.0}, uv) == Status::kDegenerate);
        CHECK(camera.project({0.0, 0.0, nan}, uv) == Status::kDegenerate);
        CHECK(camera.unproject({nan, 1.0}, uv) == Status::kDegenerate);
        CHECK(camera.unproject({1e9, 1e9}, uv) == Status::kDegenerate);
        CHECK(uv == Eigen::Vector2d(-7.0, -8.0));
    }
}

TEST_CASE("the radius of use ends where the distortion folds") {
    CameraIntrinsics k = radial_tangential();
    k.coeffs = {-0.3, 0.0, 0.0, 0.0};  // 1 - 0.9 r^2 = 0 at r = 1.054
    const CameraModel camera(k);
    CHECK(camera.max_radius() > 0.95);
    CHECK(camera.max_radius() < 1.054);
    Eigen::Vector2d uv;
    CHECK(ok(camera.project({0.9, 0.0, 1.0}, uv)));
    CHECK(camera.project({1.2, 0.0, 1.0}, uv) == Status::kDegenerate);
}

TEST_CASE("in_image keeps the border") {
    const CameraModel camera(pinhole());
    CHECK(camera.in_image({0.0, 0.0}, 0.0));
    CHECK(camera.in_image({639.0, 479.0}, 0.0));
    CHECK_FALSE(camera.in_image({639.5, 100.0}, 0.0));
    CHECK_FALSE(camera.in_image({4.9, 100.0}, 5.0));
    CHECK(camera.in_image({5.0, 474.0}, 5.0));
}

TEST_CASE("intrinsics are validated") {
    CHECK(CameraModel::validate(pinhole()) == Status::kOk);
    CHECK(CameraModel::validate(radial_tangential()) == Status::kOk);
    // Corners of a fisheye image lie outside its lens circle: they need not unproject.
    CHECK(CameraModel::validate(equidistant()) == Status::kOk);

    struct Case {
        const char* what;
        void (*spoil)(CameraIntrinsics&);
    };
    const Case cases[] = {
        {"width", [](CameraIntrinsics& k) { k.width = 0; }},
        {"height", [](CameraIntrinsics& k) { k.height = -1; }},
        {"fx zero", [](CameraIntrinsics& k) { k.fx = 0.0; }},
        {"fy negative", [](CameraIntrinsics& k) { k.fy = -1.0; }},
        {"cx", [](CameraIntrinsics& k) { k.cx = std::nan(""); }},
        {"cy", [](CameraIntrinsics& k) { k.cy = std::numeric_limits<double>::infinity(); }},
        {"coefficient", [](CameraIntrinsics& k) { k.coeffs[3] = std::nan(""); }},
        {"folds inside the image",
         [](CameraIntrinsics& k) {
             k.coeffs = {-1.5, 0.0, 0.0, 0.0};
         }},
        {"tangential part folds",
         [](CameraIntrinsics& k) {
             k.coeffs = {0.0, 0.0, 0.8, 0.0};
         }},
        {"fisheye folds",
         [](CameraIntrinsics& k) {
             k.distortion = Distortion::kEquidistant;
             k.coeffs = {-1.0, 0.0, 0.0, 0.0};
         }},
        {"a late coefficient", [](CameraIntrinsics& k) { k.more[2] = std::nan(""); }},
        {"no field of view",
         [](CameraIntrinsics& k) {
             k.distortion = Distortion::kFov;
             k.coeffs = {};
         }},
        {"denominator folds",
         [](CameraIntrinsics& k) {
             k.distortion = Distortion::kRational;
             k.more = {0.0, 3.0, 0.0, 0.0};
         }},
        {"eucm folds",
         [](CameraIntrinsics& k) {
             k.distortion = Distortion::kEucm;
             k.coeffs = {0.6, -5.0, 0.0, 0.0};
         }},
    };
    for (const Case& c : cases) {
        CAPTURE(c.what);
        CameraIntrinsics k = radial_tangential();
        c.spoil(k);
        CHECK(CameraModel::validate(k) == Status::kInvalidArgument);
    }
}

}  // namespace facet::camera_model_test
