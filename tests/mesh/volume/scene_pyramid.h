// SPDX-License-Identifier: BSD-2-Clause
// Images of made-up surfaces as the matchers take them.
#pragma once

#include <catch2/catch.hpp>

#include "estimator/frontend/image_pyramid.h"
#include "tests/mesh/depth/stereo_scene.h"

namespace facet::test {

inline ImagePyramid pyramid_of(const SceneImage& image) {
    ImagePyramid pyramid;
    REQUIRE(ok(pyramid.configure(kSceneWidth, kSceneHeight, 1)));
    pyramid.build(image.view());
    return pyramid;
}

}  // namespace facet::test
