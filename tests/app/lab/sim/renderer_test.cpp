// SPDX-License-Identifier: BSD-2-Clause
// Pictures: the two cameras agree on 3D points, rays follow the camera model, blur and noise behave.
#include "app/lab/sim/renderer.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "app/lab/sim/default_rig.h"
#include "tests/app/lab/sim/draft_scene.h"

namespace facet::sim::renderer_test {
namespace {

Flight standing(const Scene& scene, double rate) {
    Flight::Spline::Vector c = Flight::Spline::Vector::Zero();
    c.head<3>() = scene.flight_volume().start;
    std::vector<Flight::Spline::Vector> control;
    for (int i = 0; i < 8; ++i) {
        c[5] = scene.flight_volume().start_yaw_rad + rate * 0.5 * (i - 3);
        control.push_back(c);
    }
    return Flight(Flight::Spline(0.5, control));
}

Photometry quiet() {
    Photometry p;
    p.noise = false;
    p.vignette = 0.0;
    return p;
}

/// A smaller camera with the same distortion: fast to render.
CameraModel small_camera(const CameraModel& full) {
    CameraIntrinsics k = full.intrinsics();
    k.width /= 4;
    k.height /= 4;
    k.fx /= 4;
    k.fy /= 4;
    k.cx /= 4;
    k.cy /= 4;
    return CameraModel(k);
}

double mean_difference(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        sum += std::abs(a[i] - b[i]);
    }
    return sum / static_cast<double>(a.size());
}

TEST_CASE("A point seen by the left camera is met by the right camera's ray through its projection") {
    const StereoRig rig = euroc_rig();
    for (const std::string_view name : scene_names()) {
        const Scene& scene = draft_scene(name);
        const Renderer left(rig.left, rig.T_B_C0, 1, quiet());
        const Renderer right(rig.right, rig.T_B_C1, 1, quiet());
        const Flight flight = standing(scene, 0.0);
        const Se3 T_W_C0 = flight.evaluate(1.0).T_W_B * rig.T_B_C0;
        const Se3 T_W_C1 = flight.evaluate(1.0).T_W_B * rig.T_B_C1;
        int met = 0;
        int occluded = 0;
        for (int v = 10; v < 480; v += 23) {
            for (int u = 10; u < 752; u += 23) {
                const Eigen::Vector3d d0 = T_W_C0.q * left.ray(u, v);
                const RayHit hit = scene.cast(T_W_C0.p, d0);
                REQUIRE(hit.surface >= 0);
                const Eigen::Vector3d p = T_W_C0.p + hit.distance * d0;
                Eigen::Vector2d uv;
                if (!ok(rig.right.project(T_W_C1.inverse() * p, uv)) || !rig.right.in_image(uv, 0.0)) {
                    continue;
                }
                const RayHit other = scene.cast(T_W_C1.p, T_W_C1.q * right.ray(uv.x(), uv.y()));
                const double gap = other.distance - (p - T_W_C1.p).norm();
                CHECK(gap < 5e-3);  // never behind: the point itself stops the ray
                if (std::abs(gap) < 5e-3) {
                    ++met;
                } else {
                    ++occluded;
                }
            }
        }
        CHECK(met > 400);
        CHECK(occluded < met / 10);
    }
}

TEST_CASE("A fisheye sees 160 degrees across; what lies beyond its circle is black") {
    const CameraModel camera = small_camera(fisheye_rig().left);
    const CameraIntrinsics& k = camera.intrinsics();
    const Scene& scene = draft_scene("room");
    const Renderer renderer(camera, fisheye_rig().T_B_C0, 2, quiet());
    const double middle = 0.5 * k.height;
    for (const double u : {0.0, k.width - 1.0}) {
        CHECK(renderer.sees(u, middle));
        CHECK(std::acos(renderer.ray(u, middle).z()) == Approx(80.0 * EIGEN_PI / 180.0).margin(0.06));
    }
    std::vector<std::uint8_t> image;
    renderer.render({scene, standing(scene, 0.0)}, 1.0, 100.0, 1, image);
    int black = 0;
    for (int v = 0; v < k.height; ++v) {
        for (int u = 0; u < k.width; ++u) {
            if (!renderer.sees(u, v)) {
                ++black;
                CHECK(image[static_cast<std::size_t>(v * k.width + u)] == 0);
            }
        }
    }
    CHECK(black > k.width * k.height / 50);
    CHECK(black < k.width * k.height / 8);
    CHECK_FALSE(renderer.sees(0.0, 0.0));
}

TEST_CASE("Rendered values agree between the cameras where both see a point") {
    const StereoRig rig = euroc_rig();
    const Scene& scene = draft_scene("room");
    const Renderer left(rig.left, rig.T_B_C0, 2, quiet());
    const Renderer right(rig.right, rig.T_B_C1, 2, quiet());
    const Flight flight = standing(scene, 0.0);
    std::vector<std::uint8_t> image0;
    std::vector<std::uint8_t> image1;
    left.render({scene, flight}, 1.0, 100.0, 1, image0);
    right.render({scene, flight}, 1.0, 100.0, 2, image1);
    const Se3 T_W_C0 = flight.evaluate(1.0).T_W_B * rig.T_B_C0;
    const Se3 T_W_C1 = flight.evaluate(1.0).T_W_B * rig.T_B_C1;
    double sum = 0.0;
    double sum_shifted = 0.0;
    int count = 0;
    for (int v = 40; v < 440; v += 7) {
        for (int u = 150; u < 740; u += 7) {
            const Eigen::Vector3d d0 = T_W_C0.q * left.ray(u, v);
            const Eigen::Vector3d p = T_W_C0.p + scene.cast(T_W_C0.p, d0).distance * d0;
            Eigen::Vector2d uv;
            if (!ok(rig.right.project(T_W_C1.inverse() * p, uv)) || !rig.right.in_image(uv, 12.0)) {
                continue;
            }
            const auto at = [&](double x, double y) {
                const int ix = static_cast<int>(x);
                const int iy = static_cast<int>(y);
                const double fx = x - ix;
                const double fy = y - iy;
                const std::uint8_t* r = image1.data() + static_cast<std::size_t>(iy) * 752 + ix;
                return (1 - fy) * ((1 - fx) * r[0] + fx * r[1]) + fy * ((1 - fx) * r[752] + fx * r[753]);
            };
            const double own = image0[static_cast<std::size_t>(v) * 752 + static_cast<std::size_t>(u)];
            sum += std::abs(own - at(uv.x(), uv.y()));
            sum_shifted += std::abs(own - at(uv.x() + 6.0, uv.y()));
            ++count;
        }
    }
    REQUIRE(count > 2000);
    CHECK(sum / count < 6.0);
    CHECK(sum_shifted > 2.0 * sum);
}

TEST_CASE("Motion blurs along the motion, and does not move the picture") {
    const StereoRig rig = euroc_rig();
    const Scene& scene = draft_scene("room");
    Photometry slow = quiet();
    slow.exposure_s = 0.03;
    Photometry fast = quiet();
    fast.exposure_s = 0.0;
    const CameraModel camera = small_camera(rig.left);
    const Flight turning = standing(scene, 1.0);
    std::vector<std::uint8_t> sharp;
    std::vector<std::uint8_t> blurred;
    Renderer(camera, rig.T_B_C0, 8, fast).render({scene, turning}, 0.7, 100.0, 1, sharp);
    Renderer(camera, rig.T_B_C0, 8, slow).render({scene, turning}, 0.7, 100.0, 1, blurred);
    const auto contrast = [&](const std::vector<std::uint8_t>& image, int step) {
        double sum = 0.0;
        for (std::size_t i = 0; i + static_cast<std::size_t>(step) < image.size(); ++i) {
            sum += std::abs(image[i] - image[i + static_cast<std::size_t>(step)]);
        }
        return sum;
    };
    const int width = camera.intrinsics().width;
    CHECK(contrast(blurred, 1) < 0.85 * contrast(sharp, 1));
    CHECK(contrast(blurred, width) > contrast(blurred, 1) / contrast(sharp, 1) * contrast(sharp, width));
    std::vector<std::uint8_t> later;
    Renderer(camera, rig.T_B_C0, 8, fast).render({scene, turning}, 0.715, 100.0, 1, later);
    CHECK(mean_difference(blurred, sharp) < mean_difference(later, sharp));
}

TEST_CASE("Contrast scales what differs within a surface, and keeps its middle") {
    const StereoRig rig = euroc_rig();
    const Scene& full = draft_scene("room");
    SceneDetail detail = kDraft;
    detail.contrast = 0.25;
    const Scene faint = make_scene("room", detail);
    const Flight flight = standing(full, 0.0);
    const Renderer camera(small_camera(rig.left), rig.T_B_C0, 1, quiet());
    std::vector<std::uint8_t> rich;
    std::vector<std::uint8_t> poor;
    camera.render({full, flight}, 1.0, 100.0, 1, rich);
    camera.render({faint, flight}, 1.0, 100.0, 1, poor);
    const Se3 T_W_C = flight.evaluate(1.0).T_W_B * rig.T_B_C0;
    const auto surface = [&](int u, int v) { return full.cast(T_W_C.p, T_W_C.q * camera.ray(u, v)).surface; };
    double of_rich = 0.0;
    double of_poor = 0.0;
    for (int v = 0; v < camera.height(); v += 2) {
        for (int u = 0; u + 2 < camera.width(); u += 2) {
            const auto at = static_cast<std::size_t>(v * camera.width() + u);
            if (surface(u, v) == surface(u + 2, v)) {
                of_rich += std::abs(rich[at] - rich[at + 2]);
                of_poor += std::abs(poor[at] - poor[at + 2]);
            }
        }
    }
    CHECK(of_poor < 0.4 * of_rich);  // a quarter, and what light and rounding to whole grey values leave
    CHECK(of_poor > 0.15 * of_rich);
    CHECK(mean_difference(rich, poor) > 1.0);
}

TEST_CASE("Noise has the stated strength and depends on its key alone") {
    const StereoRig rig = euroc_rig();
    const Scene& scene = draft_scene("room");
    const CameraModel camera = small_camera(rig.left);
    const Flight still = standing(scene, 0.0);
    Photometry noisy = quiet();
    noisy.noise = true;
    const Renderer renderer(camera, rig.T_B_C0, 2, noisy);
    std::vector<std::uint8_t> clean;
    std::vector<std::uint8_t> a;
    std::vector<std::uint8_t> b;
    std::vector<std::uint8_t> c;
    Renderer(camera, rig.T_B_C0, 2, quiet()).render({scene, still}, 1.0, 60.0, 1, clean);
    renderer.render({scene, still}, 1.0, 60.0, 1, a);
    renderer.render({scene, still}, 1.0, 60.0, 1, b);
    renderer.render({scene, still}, 1.0, 60.0, 2, c);
    CHECK(a == b);
    CHECK(a != c);
    double sum = 0.0;
    double sum2 = 0.0;
    double expected = 0.0;
    int count = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        if (clean[i] > 8 && clean[i] < 240) {
            const double e = static_cast<double>(a[i]) - clean[i];
            sum += e;
            sum2 += e * e;
            expected += noisy.read_noise_dn * noisy.read_noise_dn + noisy.shot_noise_dn * clean[i] +
                        1.0 / 6.0;  // both are rounded
            ++count;
        }
    }
    REQUIRE(count > 10000);
    CHECK(std::abs(sum / count) < 0.05);
    CHECK(sum2 / count == Approx(expected / count).epsilon(0.08));
}

}  // namespace
}  // namespace facet::sim::renderer_test
