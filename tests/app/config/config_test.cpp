// SPDX-License-Identifier: BSD-2-Clause
#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <sstream>
#include <string_view>

#include "app/config/config_file.h"
#include "app/config/config_table.h"
#include "tests/support/input_error_text.h"
#include "tests/support/temp_dir.h"

namespace facet {
namespace {

using test::input_error_text;

TEST_CASE("the table's keys are distinct and its defaults are in range") {
    std::set<std::string_view> keys;
    for (const ConfigEntry& entry : config_table()) {
        INFO(entry.key);
        CHECK(keys.insert(entry.key).second);
        CHECK(entry.min < entry.max);
        CHECK(std::string_view(entry.meaning).size() > 5);
    }
    const ProgramConfig defaults;
    const ConfigEntry* bad = find_out_of_range(defaults);
    INFO((bad != nullptr ? bad->key : ""));
    CHECK(bad == nullptr);
}

TEST_CASE("find_out_of_range names the first bad value, NaN included") {
    ProgramConfig config;
    config.window.keyframes = 33;
    REQUIRE(find_out_of_range(config) != nullptr);
    CHECK(std::string(find_out_of_range(config)->key) == "window.keyframes");
    config = {};
    config.imu_noise.rate_hz = std::nan("");
    REQUIRE(find_out_of_range(config) != nullptr);
    CHECK(std::string(find_out_of_range(config)->key) == "imu_noise.rate_hz");
}

TEST_CASE("a file overwrites what it gives and leaves the rest") {
    const test::TempDir dir;
    ProgramConfig config;
    config.frontend.grid_rows = 5;
    const double min_distance = config.frontend.min_distance_px;
    load_config(dir.write("a.yaml",
                          "# mine\nfrontend:\n  max_features: 123\n  corner_quality: 2e-3\n"
                          "window.keyframes: 9\nfrontend.seed: 4000000000\n"),
                config);
    CHECK(config.frontend.max_features == 123);
    CHECK(config.frontend.corner_quality == 2e-3);
    CHECK(config.frontend.seed == 4000000000U);
    CHECK(config.window.keyframes == 9);
    CHECK(config.frontend.grid_rows == 5);
    CHECK(config.frontend.min_distance_px == min_distance);
    load_config(dir.write("empty.yaml", "# nothing\n"), config);
    CHECK(config.window.keyframes == 9);
}

TEST_CASE("every parameter survives printing and loading, and each one is reachable") {
    const test::TempDir dir;
    ProgramConfig config;
    double step = 0.1;
    for (const ConfigEntry& entry : config_table()) {  // somewhere inside the range, different for each
        step = std::fmod(step + 0.37, 1.0);
        const double value = entry.min + step * (entry.max - entry.min);
        std::visit(
            [&](auto* field) {
                using T = std::remove_reference_t<decltype(field(config))>;
                field(config) = static_cast<T>(value);
            },
            entry.field);
    }
    REQUIRE(find_out_of_range(config) == nullptr);
    ProgramConfig loaded;
    load_config(dir.write("all.yaml", print_config(config)), loaded);
    for (const ConfigEntry& entry : config_table()) {
        INFO(entry.key);
        CHECK(config_value(entry, loaded) == config_value(entry, config));
    }
}

TEST_CASE("bad configuration is one line with file, line and key, and changes nothing") {
    struct Bad {
        const char* text;
        const char* complaint;
    };
    const Bad bad =
        GENERATE(Bad{"frontend:\n  max_featurs: 3\n", ":2: frontend.max_featurs: unknown key"},
                 Bad{"window.keyframes: 5\nfront:\n  x: 1\n", ":2: front: unknown key"},
                 Bad{"frontend:\n  max_features: many\n", ":2: frontend.max_features: must be a number"},
                 Bad{"frontend:\n  max_features: 20.5\n", ":2: frontend.max_features: must be an integer"},
                 Bad{"frontend:\n  max_features: [1, 2]\n", ":2: frontend.max_features: must be a number"},
                 Bad{"frontend:\n  max_features: 5\n", ":2: frontend.max_features: must be within [20, 512] -, is 5"},
                 Bad{"\n\nwindow:\n  outlier_threshold_px: .inf\n", ":4: window.outlier_threshold_px: must be finite"},
                 Bad{"frontend.seed: -1\n", ":1: frontend.seed: must be within [0, 4294967295] -, is -1"},
                 Bad{"window:\n  keyframes: 5\n  keyframes: 6\n", ":3: keyframes: given twice"},
                 Bad{"window:\n  keyframes: 5\nwindow.keyframes: 6\n", ":3: window.keyframes: given twice"},
                 Bad{"window: 3\n", ":1: window: must be a map of parameters"});
    const test::TempDir dir;
    const std::string path = dir.write("c.yaml", std::string("") + bad.text);
    ProgramConfig config;
    config.window.keyframes = 7;
    CHECK(input_error_text([&] { load_config(path, config); }) == path + bad.complaint);
    CHECK(config.window.keyframes == 7);
}

TEST_CASE("a missing file is named") {
    const test::TempDir dir;
    ProgramConfig config;
    CHECK(input_error_text([&] { load_config(dir.file("no.yaml"), config); }) ==
          dir.file("no.yaml") + ": cannot be read");
}

TEST_CASE("single settings are applied and checked like a file's") {
    ProgramConfig config;
    set_config("window.keyframes=11", config);
    CHECK(config.window.keyframes == 11);
    CHECK(input_error_text([&] { set_config("window.keyframes", config); }) ==
          "--set window.keyframes: must be KEY=VALUE");
    CHECK(input_error_text([&] { set_config("window=1", config); }) == "--set window=1: unknown key");
    CHECK(input_error_text([&] {
              set_config("window.keyframes=99", config);
          }).starts_with("--set:1: window.keyframes: must be within"));
    CHECK(config.window.keyframes == 11);
}

}  // namespace
}  // namespace facet
