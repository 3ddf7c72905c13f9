// SPDX-License-Identifier: BSD-2-Clause
#include "app/config/config_reference.h"

#include <yaml-cpp/yaml.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>
#include <sstream>

#include "app/config/config_file.h"
#include "app/config/config_table.h"
#include "tests/support/temp_dir.h"

namespace facet::config_reference_test {
namespace {

TEST_CASE("every key of a vehicle file has a sentence, and every sentence a key") {
    for (const std::string& gap : reference_gaps()) {
        FAIL_CHECK(gap);
    }
}

TEST_CASE("the reference is YAML with the readers' defaults and bounds") {
    const std::string text = vehicle_reference();
    const YAML::Node root = YAML::Load(text);
    CHECK(root["cameras"]["rate_hz"].as<double>() == 20.0);
    CHECK(root["cameras"]["auto_exposure"]["latency_frames"].IsDefined());
    CHECK(root["imu"]["spi"]["data_ready"]["edge"].as<std::string>() == "rising");
    CHECK(root["imu"]["can"]["map"]["source_address"].as<int>() == -1);
    CHECK(root["sinks"]["mavlink"]["component"].as<int>() == 197);
    CHECK(root["sinks"]["log"]["keep_mb"].as<int>() == 4096);
    CHECK(root["realtime"]["threads"]["output"]["priority"].as<int>() == 0);
    CHECK(text.find("# Hz, [1, 200]. Pairs of images per second.\n  rate_hz: 20\n") != std::string::npos);
    CHECK(text.find("required, one of: adis16448, ") != std::string::npos);
    // A key that two chips have otherwise.
    CHECK(text.find("with chip: icm42688, Hz, one of: 200, 500, 1000, 2000. ") != std::string::npos);
    CHECK(text.find("with chip: bmi088, Hz, one of: 200, 400, 1000, 2000. ") != std::string::npos);
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        INFO(line);
        CHECK(line.size() <= 120);
    }
}

TEST_CASE("the reference of the parameters is a file of the defaults") {
    const test::TempDir dir;
    ProgramConfig config;
    config.frontend.max_features += 1;
    load_config(dir.write("parameters.yaml", parameter_reference()), config);
    for (const ConfigEntry& entry : config_table()) {
        INFO(entry.key());
        CHECK(entry.value(config) == entry.value(ProgramConfig{}));
    }
}

TEST_CASE("the reference in docs is that of this program") {
    std::ifstream file(FACET_REFERENCE, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    // Made anew by: facet check-config --reference > docs/configuration.yaml
    CHECK(text.find(vehicle_reference()) != std::string::npos);
    CHECK(text.find(parameter_reference()) != std::string::npos);
}

}  // namespace
}  // namespace facet::config_reference_test
