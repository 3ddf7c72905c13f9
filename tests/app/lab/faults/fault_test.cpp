// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/faults/fault.h"

#include <catch2/catch.hpp>
#include <set>

#include "tests/support/input_error_text.h"

namespace facet::fault_test {
namespace {

std::string complaint(const std::string& spec) {
    return test::input_error_text([&] { parse_fault(spec); });
}

TEST_CASE("a fault is read with its values and its time") {
    const Fault flash = parse_fault("flash=8.5@12.25+0.3");
    CHECK(flash.kind == FaultKind::kFlash);
    CHECK(flash.values[0] == 8.5);
    CHECK(flash.begin.ns == 12'250'000'000);
    CHECK(flash.length.ns == 300'000'000);
    CHECK(flash.spec == "flash=8.5@12.25+0.3");

    const Fault clip = parse_fault("clip=80,9@8+0.1");
    CHECK(clip.values[0] == 80.0);
    CHECK(clip.values[1] == 9.0);
    CHECK(parse_fault("time_offset=-0.005").values[0] == -0.005);
}

TEST_CASE("what is left out has its default, and no end") {
    using Values = std::array<double, 4>;
    CHECK(parse_fault("clip@8+0.1").values == Values{160.0, 17.0, 0.0, 0.0});
    CHECK(parse_fault("clip=80").values == Values{80.0, 17.0, 0.0, 0.0});
    CHECK(parse_fault("clip=80,9,accel").values == Values{80.0, 9.0, 2.0, 0.0});
    CHECK(parse_fault("drop_frames=0.1").values == Values{0.1, 1.0, 0.0, 0.0});
    CHECK(parse_fault("calibration").values == Values{1.0, 1.0, 0.0, 0.0});
    CHECK(parse_fault("calibration=1.5,4").values == Values{1.5, 4.0, 0.0, 0.0});
    CHECK(parse_fault("calibration=1.5,4,tails").values == Values{1.5, 4.0, 1.0, 0.0});
    CHECK(parse_fault("vibration=flight").values == Values{1.0, 1.0, 1.0, 0.0});
    CHECK(parse_fault("vibration=idle,7@2").values == Values{0.0, 7.0, 1.0, 0.0});
    CHECK(parse_fault("vibration=flight,7,3").values == Values{1.0, 7.0, 3.0, 0.0});
    CHECK(word_of<VibrationShown>(parse_fault("vibration=flight,7,3,images"), 3) == VibrationShown::kImages);
    CHECK(word_of<FaultCamera>(parse_fault("freeze"), 0) == FaultCamera::kBoth);
    CHECK(word_of<FaultCamera>(parse_fault("dark=0.1,right@3"), 1) == FaultCamera::kRight);
    CHECK(word_of<FaultPart>(parse_fault("imu_nan=0.5,gyro"), 1) == FaultPart::kGyro);
    CHECK(word_of<AxesError>(parse_fault("imu_axes=mirror"), 0) == AxesError::kMirror);
    CHECK(shifts_stamps(parse_fault("imu_jump=-3600")));
    CHECK_FALSE(shifts_stamps(parse_fault("imu_gap")));
    CHECK_FALSE(is_of_samples(parse_fault("calibration")));
    const Fault from_the_start = parse_fault("no_right");
    CHECK(from_the_start.is_active(Duration::from_seconds(0.0)));
    CHECK(from_the_start.is_active(Duration::from_seconds(1e6)));
    CHECK_FALSE(from_the_start.is_active(Duration::from_seconds(-0.1)));
    const Fault to_the_end = parse_fault("no_right@5");
    CHECK_FALSE(to_the_end.is_active(Duration::from_seconds(4.999)));
    CHECK(to_the_end.is_active(Duration::from_seconds(1e6)));
}

TEST_CASE("a time is half open") {
    const Fault fault = parse_fault("blackout@8+1");
    CHECK_FALSE(fault.is_active(Duration::from_seconds(7.999999)));
    CHECK(fault.is_active(Duration::from_seconds(8.0)));
    CHECK(fault.is_active(Duration::from_seconds(8.999999)));
    CHECK_FALSE(fault.is_active(Duration::from_seconds(9.0)));
}

TEST_CASE("every error names the specification and the token") {
    const struct {
        const char* spec;
        const char* complaint;
    } cases[] = {
        {"", "--inject '': unknown fault ''; must be one of blackout, flash, dark, "},
        {"fog@8", "--inject 'fog@8': unknown fault 'fog'; must be one of "},
        {"Blackout", "unknown fault 'Blackout'"},
        {"blackout@x+1", "--inject 'blackout@x+1': start 'x' is not a number"},
        {"blackout@", "start '' is not a number"},
        {"blackout@-1", "start '-1' must be within [0, "},
        {"blackout@nan", "start 'nan' must be within"},
        {"blackout@8+", "length '' is not a number"},
        {"blackout@8+0", "length '0' must be within"},
        {"blackout@8+1+2", "length '1+2' is not a number"},
        {"blackout@8@9", "start '8@9' is not a number"},
        {"no_left=3@8", "'no_left' takes no value, found '3'"},
        {"blackout=3@8", "CAMERA '3' must be one of both, left, right"},
        {"flash=2,left,3", "'flash' takes no further value '3'"},
        {"frame_thin=1", "N '1' must be within [2, 1000]"},
        {"flash=", "GAIN '' is not a number"},
        {"flash=0.5", "GAIN '0.5' must be within [1, 255]"},
        {"time_offset", "'time_offset' needs a value: time_offset=SECONDS"},
        {"time_offset@8", "'time_offset' needs a value"},
        {"drop_frames=1.5", "SHARE '1.5' must be within [0, 1]"},
        {"drop_frames=0.1,z", "SEED 'z' is not a number"},
        {"vibration", "'vibration' needs a value: vibration=KIND"},
        {"vibration=3", "KIND '3' must be one of idle, flight"},
        {"vibration=flight,1,1,image", "SHOWN 'image' must be one of samples, images"},
        {"vibration=flight,images", "SEED 'images' is not a number"},
        {"vibration=flight,1,1,images,2", "'vibration' takes no further value '2'"},
        {"calibration@3", "'calibration' holds for the whole run: no start"},
        {"calibration=-1", "K '-1' must be within [0, 100]"},
    };
    for (const auto& c : cases) {
        INFO(c.spec);
        const std::string text = complaint(c.spec);
        INFO(text);
        CHECK(text.find(c.complaint) != std::string::npos);
    }
}

TEST_CASE("the table has each kind once, and help names all") {
    std::set<FaultKind> kinds;
    const std::string help = fault_help();
    for (const FaultInfo& info : fault_table()) {
        INFO(info.name);
        CHECK(kinds.insert(info.kind).second);
        CHECK(info.values.size() <= Fault::kMaxValues);
        CHECK(help.find(std::string("\n  ") + info.name) != std::string::npos);
    }
    CHECK(kinds.size() == static_cast<std::size_t>(FaultKind::kCount));
    CHECK(help.find("clip[=ACCEL[,GYRO[,PART]]] ") != std::string::npos);
    CHECK(help.find("(default PART both)") != std::string::npos);
    CHECK(help.find("drop_frames=SHARE[,SEED] ") != std::string::npos);
}

}  // namespace
}  // namespace facet::fault_test
