// SPDX-License-Identifier: BSD-2-Clause
// Normal gravity against published values; the configuration's two ways to say how strong gravity is.
#include "estimator/values/gravity.h"

#include <catch2/catch.hpp>

#include "tests/support/check_fields.h"

namespace facet::gravity_test {

TEST_CASE("normal gravity has the published values of the WGS84 ellipsoid", "[gravity]") {
    CHECK(normal_gravity_m_per_s2(0.0, 0.0) == Approx(9.7803253359).epsilon(1e-11));
    CHECK(normal_gravity_m_per_s2(90.0, 0.0) == Approx(9.8321849378).epsilon(1e-11));
    CHECK(normal_gravity_m_per_s2(45.0, 0.0) == Approx(9.8061977694).epsilon(1e-10));
    CHECK(normal_gravity_m_per_s2(-33.0, 100.0) == normal_gravity_m_per_s2(33.0, 100.0));
}

TEST_CASE("normal gravity falls with height as from the Earth's centre", "[gravity]") {
    // -0.3086 mGal a metre at 45 degrees, the free-air gradient; -0.3084 over the first kilometre's mean.
    const double ground = normal_gravity_m_per_s2(45.0, 0.0);
    CHECK((normal_gravity_m_per_s2(45.0, 1.0) - ground) == Approx(-3.0855e-6).epsilon(1e-3));
    const double kilometres = 10.0;
    CHECK(normal_gravity_m_per_s2(45.0, 1000.0 * kilometres) ==
          Approx(ground - 3.0855e-3 * kilometres + 7.2e-7 * kilometres * kilometres).epsilon(1e-6));
}

TEST_CASE("gravity is the magnitude given, or that of the latitude", "[gravity]") {
    GravityConfig config;
    CHECK(config.norm_m_per_s2() == 9.81);
    config.magnitude_m_per_s2 = 9.78;
    config.latitude_deg = 60.0;
    CHECK(config.norm_m_per_s2() == 9.78);
    config.from_latitude = true;
    config.altitude_m = 300.0;
    CHECK(config.norm_m_per_s2() == normal_gravity_m_per_s2(60.0, 300.0));
}

TEST_CASE("the gravity config is validated field by field", "[gravity]") { test::check_fields(kGravityFields); }

}  // namespace facet::gravity_test
