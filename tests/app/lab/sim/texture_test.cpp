// SPDX-License-Identifier: BSD-2-Clause
// Texture maps: period, interpolation, mip levels; patterns: repeatable and seamless.
#include "app/lab/sim/texture.h"

#include <catch2/catch.hpp>

#include "app/lab/sim/patterns.h"

namespace facet::sim::texture_test {
namespace {

TEST_CASE("A texture interpolates between texel centres and repeats") {
    const Texture t(2, {0.0F, 1.0F, 0.2F, 0.6F});
    CHECK(t.sample(0.25F, 0.25F, 0.0F) == Approx(0.0));
    CHECK(t.sample(0.75F, 0.25F, 0.0F) == Approx(255.0));
    CHECK(t.sample(0.5F, 0.25F, 0.0F) == Approx(127.5));
    CHECK(t.sample(0.25F, 0.5F, 0.0F) == Approx(25.5));
    CHECK(t.sample(3.75F, -2.75F, 0.0F) == Approx(255.0));
    CHECK(t.sample(0.1F, 0.9F, 4.0F) == Approx(115.0).margin(1.0));  // wider than the square: its mean
}

TEST_CASE("Wider footprints smooth without changing the mean") {
    const Texture t = bake_pattern(Pattern::kTiles, 3, 128, 1);
    double variances[3] = {};
    double means[3] = {};
    const float footprints[3] = {0.0F, 0.03F, 0.12F};
    for (int f = 0; f < 3; ++f) {
        double sum = 0.0;
        double sum2 = 0.0;
        for (int i = 0; i < 4096; ++i) {
            const double g = t.sample(static_cast<float>(i % 64) / 64.0F + 0.003F,
                                      static_cast<float>(i / 64) / 64.0F + 0.001F, footprints[f]);
            sum += g;
            sum2 += g * g;
        }
        means[f] = sum / 4096;
        variances[f] = sum2 / 4096 - means[f] * means[f];
    }
    CHECK(means[1] == Approx(means[0]).margin(2.0));
    CHECK(means[2] == Approx(means[0]).margin(2.0));
    CHECK(variances[0] > 1.2 * variances[1]);
    CHECK(variances[1] > 1.2 * variances[2]);
}

TEST_CASE("Patterns do not depend on the number of threads and differ by seed") {
    const Texture one = bake_pattern(Pattern::kPoster, 3, 64, 1);
    const Texture two = bake_pattern(Pattern::kPoster, 3, 64, 3);
    const Texture other = bake_pattern(Pattern::kPoster, 4, 64, 1);
    int differing = 0;
    for (int i = 0; i < 4096; ++i) {
        const float s = static_cast<float>(i % 64) / 64.0F;
        const float t = static_cast<float>(i / 64) / 64.0F;
        REQUIRE(one.sample(s, t, 0.0F) == two.sample(s, t, 0.0F));
        differing += std::abs(one.sample(s, t, 0.0F) - other.sample(s, t, 0.0F)) > 20.0F ? 1 : 0;
    }
    CHECK(differing > 400);
}

}  // namespace
}  // namespace facet::sim::texture_test
