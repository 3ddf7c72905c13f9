// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/volume/depth_samples.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>

#include "tests/mesh/volume/scene_pyramid.h"

namespace facet::depth_samples_test {
namespace {

/// A keyframe at the origin, whose mesher knows nothing.
struct Stage {
    DepthSampler sampler{test::scene_rig(), 4};
    std::unique_ptr<Mesher> mesher = std::make_unique<Mesher>();
    test::Surface surface;
    ImagePyramid left;

    explicit Stage(const test::Surface& seen)
        : surface(seen), left(test::pyramid_of(test::draw(seen, {0.0, 0.0, 0.0}))) {
        REQUIRE(ok(mesher->configure({}, test::scene_rig().left)));
    }
    std::vector<DepthSample> measure() {
        const ImagePyramid right = test::pyramid_of(test::draw(surface, {0.1, 0.0, 0.0}));
        sampler.correct({});
        std::vector<DepthSample> samples;
        for (int i = 0; i < sampler.count(); ++i) {
            samples.push_back(sampler.measure(i, left, right, mesher.get()));
        }
        return samples;
    }
    void compare(const test::Surface& seen, const Eigen::Vector3d& from, std::vector<DepthSample>& samples) {
        sampler.face({Eigen::Quaterniond::Identity(), from}, {});
        const ImagePyramid other = test::pyramid_of(test::draw(seen, from));
        for (DepthSample& sample : samples) {
            sampler.compare(left, other, sample);
        }
    }
};

/// Root mean square of the error of the inverse depth of those that are known, and how many they are.
struct Errors {
    double rms = 0.0;
    int count = 0;
};
Errors errors_of(const std::vector<DepthSample>& samples, double truth, bool confirmed_only = false) {
    Errors errors;
    for (const DepthSample& s : samples) {
        if (s.inverse_depth > 0.0F && (!confirmed_only || s.confirmed > 0)) {
            errors.rms += std::pow(static_cast<double>(s.inverse_depth) - truth, 2);
            ++errors.count;
        }
    }
    errors.rms = std::sqrt(errors.rms / errors.count);
    return errors;
}

TEST_CASE("most squares of a textured wall are measured, each as well as it says") {
    Stage stage(test::plane_surface(Eigen::Vector3d::UnitZ(), 2.5));
    const auto samples = stage.measure();
    REQUIRE(samples.size() == 80U * 60U);
    int good = 0;
    for (const DepthSample& s : samples) {
        good += s.inverse_depth > 0.0F && std::abs(s.inverse_depth - 0.4F) < 4.0F * s.sigma ? 1 : 0;
    }
    const Errors errors = errors_of(samples, 0.4);
    CHECK(errors.count > 3000);
    CHECK(good > 0.99 * errors.count);
}

TEST_CASE("another place confirms depths and makes them more certain") {
    Stage stage(test::plane_surface(Eigen::Vector3d::UnitZ(), 2.5));
    auto samples = stage.measure();
    const auto before = samples;
    stage.compare(stage.surface, {0.25, 0.1, 0.0}, samples);
    int confirmed = 0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        confirmed += samples[i].confirmed;
        CHECK((samples[i].confirmed == 0 || samples[i].sigma < before[i].sigma));
    }
    CHECK(confirmed > 2000);
    CHECK(errors_of(samples, 0.4, true).rms < 0.7 * errors_of(before, 0.4).rms);
}

TEST_CASE("a place from which it is elsewhere contradicts it") {
    Stage stage(test::plane_surface(Eigen::Vector3d::UnitZ(), 2.5));
    auto samples = stage.measure();
    for (DepthSample& s : samples) {  // two pixels of the motion off, and very sure of it
        s.inverse_depth *= s.inverse_depth > 0.0F ? 1.07F : 1.0F;
        s.sigma = 0.004F;
    }
    stage.compare(stage.surface, {0.3, 0.0, 0.0}, samples);
    const auto contradicted =
        std::count_if(samples.begin(), samples.end(), [](const auto& s) { return s.contradicted > 0; });
    const auto confirmed = std::count_if(samples.begin(), samples.end(), [](const auto& s) { return s.confirmed > 0; });
    CHECK(contradicted > 100);
    CHECK(confirmed < contradicted / 10);
}

TEST_CASE("motion along a pixel's own ray shows nothing about it") {
    Stage stage(test::plane_surface(Eigen::Vector3d::UnitZ(), 2.5));
    auto samples = stage.measure();
    stage.compare(stage.surface, {0.0, 0.0, 0.15}, samples);
    for (const DepthSample& s : samples) {
        CHECK((s.confirmed == 0 || s.xy.norm() > 0.3F));
    }
}

}  // namespace
}  // namespace facet::depth_samples_test
