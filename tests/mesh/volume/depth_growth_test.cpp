// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/volume/depth_growth.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "tests/mesh/volume/scene_pyramid.h"
#include "tests/support/allocation_guard.h"

namespace facet::depth_growth_test {
namespace {

/// A keyframe at the origin, before a surface.
struct Image {
    explicit Image(const test::Surface& seen)
        : left(test::pyramid_of(test::draw(seen, {0.0, 0.0, 0.0}))),
          right(test::pyramid_of(test::draw(seen, {0.1, 0.0, 0.0}))) {
        sampler.correct({});
    }

    /// What each square gives when all depths are searched.
    std::vector<DepthSample> alone() {
        std::vector<DepthSample> samples;
        for (int i = 0; i < sampler.count(); ++i) {
            samples.push_back(sampler.measure(i, left, right, nullptr));
        }
        return samples;
    }
    /// @param places  that were compared
    std::vector<DepthSample> grown(const std::vector<DepthSeed>& seeds, long& places) {
        std::vector<DepthSample> samples(static_cast<std::size_t>(sampler.count()));
        const test::AllocationGuard guard;
        growth.begin(seeds);
        places = 0;
        for (int step = 0; (step = growth.advance(left, right, samples)) >= 0;) {
            places += step;
        }
        const std::uint64_t allocations = guard.allocations();
        CHECK(allocations == 0);
        return samples;
    }

    DepthSampler sampler{test::scene_rig(), 4};
    DepthGrowth growth{sampler};
    ImagePyramid left;
    ImagePyramid right;
};

struct Differences {
    int both = 0;
    int apart = 0;
    int lost = 0;
};

Differences compare(const std::vector<DepthSample>& alone, const std::vector<DepthSample>& grown) {
    Differences d;
    for (std::size_t i = 0; i < alone.size(); ++i) {
        const bool is_known = alone[i].inverse_depth > 0.0F;
        d.lost += is_known && grown[i].inverse_depth == 0.0F ? 1 : 0;
        if (is_known && grown[i].inverse_depth > 0.0F) {
            ++d.both;
            d.apart += std::abs(alone[i].inverse_depth - grown[i].inverse_depth) > 0.01F ? 1 : 0;
        }
    }
    return d;
}

TEST_CASE("grown depths are those of a search of all depths, also beside a step, at a fraction of the work") {
    Image image(test::step_surface(1.5, 2.5));
    const auto alone = image.alone();
    const double all = (image.sampler.all_depths().nearest / image.sampler.per_px()) * image.sampler.count();
    long without_seeds = 0;
    const Differences d = compare(alone, image.grown({}, without_seeds));
    REQUIRE(d.both > 3000);
    CHECK(d.apart < d.both / 100);
    CHECK(d.lost < d.both / 20);
    CHECK(static_cast<double>(without_seeds) < 0.4 * all);
    long with_seeds = 0;
    const std::vector<DepthSeed> seeds{{30 * 80 + 10, 0.4F}, {30 * 80 + 70, 1.0F / 1.5F}};
    const Differences seeded = compare(alone, image.grown(seeds, with_seeds));
    CHECK(seeded.apart < seeded.both / 100);
    CHECK(seeded.lost < seeded.both / 20);
    CHECK(with_seeds <= without_seeds);
}

TEST_CASE("a wrong seed does not spread") {
    Image image(test::plane_surface(Eigen::Vector3d::UnitZ(), 2.5));
    const auto alone = image.alone();
    long places = 0;
    const Differences d = compare(alone, image.grown({{30 * 80 + 40, 1.2F}}, places));
    CHECK(d.apart < d.both / 200);
    CHECK(d.lost < d.both / 20);
}

TEST_CASE("where nothing matches, most squares are left alone") {
    // Two images of different walls.
    Image image(test::plane_surface(Eigen::Vector3d::UnitZ(), 2.5));
    image.right =
        test::pyramid_of(test::draw(test::plane_surface(Eigen::Vector3d::UnitZ(), 2.5, 0.049), {7.0, 3.0, 0.0}));
    long places = 0;
    (void)image.grown({}, places);
    const double all = (image.sampler.all_depths().nearest / image.sampler.per_px()) * image.sampler.count();
    CHECK(static_cast<double>(places) < 0.75 * all);
}

}  // namespace
}  // namespace facet::depth_growth_test
