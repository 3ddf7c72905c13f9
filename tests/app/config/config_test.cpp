// SPDX-License-Identifier: BSD-2-Clause
#include <fmt/format.h>
#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <sstream>

#include "app/config/config_file.h"
#include "app/config/config_table.h"
#include "tests/support/check_fields.h"
#include "tests/support/input_error_text.h"
#include "tests/support/temp_dir.h"

namespace facet::config_test {
namespace {

using test::input_error_text;

TEST_CASE("every section's table is sound, and sections and keys are distinct") {
    std::set<std::string> sections;
    for_each_section([&](const char* name, auto section, const auto& fields) {
        INFO(name);
        CHECK(sections.insert(name).second);
        CHECK((ProgramConfig{}.*section).validate() == Status::kOk);
        test::check_fields(fields);
    });
    std::set<std::string> keys;
    for (const ConfigEntry& entry : config_table()) {
        CHECK(keys.insert(entry.key()).second);
    }
    CHECK(describe_fault(ProgramConfig{}).empty());
}

TEST_CASE("a fault is described by name, value and range, NaN included") {
    ProgramConfig config;
    config.window.keyframes = 33;
    CHECK(describe_fault(config) == "window.keyframes: must be within [3, 32], is 33");
    config = {};
    config.imu_noise.rate_hz = std::nan("");
    CHECK(describe_fault(config) == "imu_noise.rate_hz: must be within [20, 10000] Hz, is nan");
    config = {};
    config.frontend.window_px = 16;
    CHECK(describe_fault(config) == "frontend: window_px must be odd");
}

TEST_CASE("parameters that differ from their defaults are named as in a file") {
    ProgramConfig config;
    CHECK(changed_parameters(config).empty());
    set_config("regularity.use_gravity=false", config);
    set_config("frontend.max_features=50", config);
    CHECK(changed_parameters(config) ==
          std::map<std::string, std::string>{{"frontend.max_features", "50"}, {"regularity.use_gravity", "false"}});
    set_config("frontend.max_features=" + std::to_string(ProgramConfig{}.frontend.max_features), config);
    CHECK(changed_parameters(config).size() == 1);
}

TEST_CASE(
    "every parameter refuses a value outside its range, in a file by its line and on the command line by the option") {
    const test::TempDir dir;
    for (const ConfigEntry& entry : config_table()) {
        if (entry.type == ParameterType::kBool || !entry.choices.empty()) {
            continue;
        }
        for (const double bad : {entry.min - 1.0, entry.max + 1.0}) {
            ProgramConfig config;
            const std::string value = fmt::format("{}", bad);
            const std::string unit = entry.unit == "-" ? "" : fmt::format(" {}", entry.unit);
            const std::string complaint =
                fmt::format(": must be within [{}, {}]{}, is {}", entry.min, entry.max, unit, value);
            const std::string path =
                dir.write("bad.yaml", fmt::format("# one\n{}:\n  {}: {}\n", entry.section, entry.name, value));
            CHECK(input_error_text([&] { load_config(path, config); }) == path + ":3: " + entry.key() + complaint);
            const std::string setting = entry.key() + "=" + value;
            CHECK(input_error_text([&] { set_config(setting, config); }) == "--set " + setting + complaint);
        }
    }
}

TEST_CASE("the names of the modes are in the order of their enumerators") {
    CHECK(to_string(RegularityMode::kS) == "s");
    CHECK(to_string(RegularityMode::kSp) == "sp");
    CHECK(to_string(RegularityMode::kSpr) == "spr");
}

TEST_CASE("a file overwrites what it gives and leaves the rest") {
    const test::TempDir dir;
    ProgramConfig config;
    config.frontend.surface_points = 5;
    const double min_depth = config.frontend.min_depth_m;
    load_config(dir.write("a.yaml",
                          "# mine\nfrontend:\n  max_features: 123\n  keyframe_disparity_px: 2e-1\n"
                          "window.keyframes: 9\nfrontend.seed: 4000000000\n"),
                config);
    CHECK(config.frontend.max_features == 123);
    CHECK(config.frontend.keyframe_disparity_px == 0.2);
    CHECK(config.frontend.seed == 4000000000U);
    CHECK(config.window.keyframes == 9);
    CHECK(config.frontend.surface_points == 5);
    CHECK(config.frontend.min_depth_m == min_depth);
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
        entry.set(config, entry.type == ParameterType::kReal ? value : std::round(value));
    }
    ProgramConfig loaded;
    load_config(dir.write("all.yaml", print_config(config)), loaded);
    for (const ConfigEntry& entry : config_table()) {
        INFO(entry.key());
        CHECK(entry.value(loaded) == entry.value(config));
    }
}

TEST_CASE("bad configuration is one line with file, line and key, and changes nothing") {
    struct Bad {
        const char* text;
        const char* complaint;
    };
    const Bad bad = GENERATE(
        Bad{"frontend:\n  max_featurs: 3\n", ":2: frontend.max_featurs: unknown key"},
        Bad{"window.keyframes: 5\nfront:\n  x: 1\n", ":2: front: unknown key"},
        Bad{"frontend:\n  max_features: many\n", ":2: frontend.max_features: must be a number"},
        Bad{"frontend:\n  max_features: 20.5\n", ":2: frontend.max_features: must be an integer"},
        Bad{"frontend:\n  max_features: [1, 2]\n", ":2: frontend.max_features: must be a number"},
        Bad{"frontend:\n  backend: opencl\n", ":2: frontend.backend: 'opencl' is unknown; one of: own, opencv"},
        Bad{"frontend:\n  max_features: 5\n", ":2: frontend.max_features: must be within [20, 512], is 5"},
        Bad{"\n\nwindow:\n  pixel_sigma_px: .inf\n", ":4: window.pixel_sigma_px: must be finite"},
        Bad{"frontend.seed: -1\n", ":1: frontend.seed: must be within [0, 4294967295], is -1"},
        Bad{"window:\n  keyframes: 5\n  keyframes: 6\n", ":3: keyframes: given twice"},
        Bad{"window:\n  keyframes: 5\nwindow.keyframes: 6\n", ":3: window.keyframes: given twice"},
        Bad{"window: 3\n", ":1: window: must be a map of parameters"},
        Bad{"window.keyframes: 5\n---\nwindow.keyframes: 6\n", ":2: the file goes on behind the end of its document"},
        Bad{",a]\nc: 1\n", ":1: the file goes on behind the end of its document"});
    const test::TempDir dir;
    const std::string path = dir.write("c.yaml", std::string("") + bad.text);
    ProgramConfig config;
    config.window.keyframes = 7;
    CHECK(input_error_text([&] { load_config(path, config); }) == path + bad.complaint);
    CHECK(config.window.keyframes == 7);
}

TEST_CASE("a file that refers to itself, or is not a file, is refused with one line") {
    const test::TempDir dir;
    ProgramConfig config;
    const std::string itself = dir.write("itself.yaml", "window:\n  keyframes: &a [*a]\n");
    CHECK(input_error_text([&] { load_config(itself, config); }) ==
          itself + ":2: aliases (*name) are not accepted: write the value out");
    std::string bomb = "a0: &a0 [1, 1]\n";
    for (int i = 1; i < 40; ++i) {
        bomb += fmt::format("a{0}: &a{0} [*a{1}, *a{1}]\n", i, i - 1);
    }
    const std::string path = dir.write("bomb.yaml", bomb);
    CHECK(input_error_text([&] { load_config(path, config); }).starts_with(path + ":2: aliases (*name)"));
    REQUIRE(mkfifo(dir.file("pipe.yaml").c_str(), 0600) == 0);
    CHECK(input_error_text([&] { load_config(dir.file("pipe.yaml"), config); }) ==
          dir.file("pipe.yaml") + ": is not a regular file");
    CHECK(input_error_text([&] { load_config("/dev/zero", config); }) == "/dev/zero: is not a regular file");
}

TEST_CASE("a missing file is named, and a directory refused") {
    const test::TempDir dir;
    ProgramConfig config;
    CHECK(input_error_text([&] { load_config(dir.path(), config); }) == dir.path() + ": is a directory");
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
    CHECK(input_error_text([&] { set_config("window.keyframes=99", config); }) ==
          "--set window.keyframes=99: must be within [3, 32], is 99");
    CHECK(input_error_text([&] { set_config("window.spread_keyframes=2", config); }) ==
          "--set window.spread_keyframes=2: must be true or false");
    set_config("window.spread_keyframes=false", config);
    CHECK_FALSE(config.window.spread_keyframes);
    CHECK(config.window.keyframes == 11);
}

}  // namespace
}  // namespace facet::config_test
