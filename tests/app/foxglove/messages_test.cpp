// SPDX-License-Identifier: BSD-2-Clause
#include "app/foxglove/messages.h"

#include <catch2/catch.hpp>
#include <limits>
#include <vector>

#include "app/foxglove/schemas.h"
#include "tests/app/foxglove/schema_check.h"

namespace facet::messages_test {
namespace {

using nlohmann::json;

constexpr Timestamp kStamp{1'403'636'579'763'555'584};
const Se3 kPose{Eigen::Quaterniond(0.5, -0.5, 0.5, 0.5), {1.0 / 3.0, -2e-7, 12345.678901234}};

std::string fault_of(const std::string& message, FoxgloveSchema schema) {
    return test::schema_fault(json::parse(message), json::parse(schema_text(schema)));
}

TEST_CASE("every message is as its schema says") {
    const std::vector<std::uint8_t> file{1, 2, 3, 255};
    const std::vector<Se3> path{kPose, Se3{}};
    CHECK(fault_of(pose_message(kStamp, kWorldFrame, kPose), FoxgloveSchema::kPoseInFrame).empty());
    CHECK(fault_of(path_message(kStamp, kWorldFrame, path), FoxgloveSchema::kPosesInFrame).empty());
    CHECK(fault_of(transform_message(kStamp, kWorldFrame, kBodyFrame, kPose), FoxgloveSchema::kFrameTransform).empty());
    CHECK(fault_of(image_message(kStamp, kCameraFrame, file, "png"), FoxgloveSchema::kCompressedImage).empty());
    CHECK(fault_of(health_message(kStamp, {}, "few_features|vibration"), FoxgloveSchema::kHealth).empty());
    CHECK(fault_of(calibration_message(kStamp, {}), FoxgloveSchema::kCalibration).empty());
    CHECK(fault_of(timing_message(kStamp, true, {}), FoxgloveSchema::kTiming).empty());
}

TEST_CASE("distinguishes messages that follow their schema from those that do not") {
    json pose = json::parse(pose_message(kStamp, kWorldFrame, kPose));
    pose["pose"]["position"].erase("y");
    CHECK(fault_of(pose.dump(), FoxgloveSchema::kPoseInFrame) == ".pose.position.y: missing");
    CHECK(fault_of(transform_message(kStamp, "a", "b", kPose), FoxgloveSchema::kPoseInFrame) == ".frame_id: missing");
}

TEST_CASE("numbers keep all their digits, and stamps their nanoseconds") {
    const json pose = json::parse(pose_message(kStamp, kWorldFrame, kPose));
    CHECK(pose["timestamp"]["sec"] == 1'403'636'579);
    CHECK(pose["timestamp"]["nsec"] == 763'555'584);
    CHECK(pose["frame_id"] == "world");
    CHECK(pose["pose"]["position"]["x"].get<double>() == kPose.p.x());
    CHECK(pose["pose"]["position"]["y"].get<double>() == kPose.p.y());
    CHECK(pose["pose"]["position"]["z"].get<double>() == kPose.p.z());
    CHECK(pose["pose"]["orientation"] == json{{"x", -0.5}, {"y", 0.5}, {"z", 0.5}, {"w", 0.5}});
    CHECK(json::parse(pose_message(Timestamp{-5}, "a", kPose))["timestamp"] == json{{"sec", 0}, {"nsec", 0}});
    const Se3 broken{Eigen::Quaterniond::Identity(), {std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0}};
    CHECK(json::parse(pose_message(kStamp, "a", broken))["pose"]["position"]["x"].is_null());
}

TEST_CASE("images are in base 64") {
    const auto data_of = [](const std::string& bytes) {
        const std::vector<std::uint8_t> file(bytes.begin(), bytes.end());
        return json::parse(image_message(kStamp, "camera", file, "png"))["data"].get<std::string>();
    };
    // The examples of RFC 4648.
    CHECK(data_of("").empty());
    CHECK(data_of("f") == "Zg==");
    CHECK(data_of("fo") == "Zm8=");
    CHECK(data_of("foo") == "Zm9v");
    CHECK(data_of("foob") == "Zm9vYg==");
    CHECK(data_of("fooba") == "Zm9vYmE=");
    CHECK(data_of("\xff\xfe\xfd") == "//79");
}

TEST_CASE("health, calibration and timing are found under the names of their files' columns") {
    Health health;
    health.state = TrackingState::kDegraded;
    health.reasons = kReasonVibration;
    health.tracked = 42;
    health.time_offset_s = -0.003;
    const json said = json::parse(health_message(kStamp, health, "vibration"));
    CHECK(said["state"] == "DEGRADED");
    CHECK(said["reasons"] == kReasonVibration);
    CHECK(said["reason_names"] == "vibration");
    CHECK(said["tracked"] == 42);
    CHECK(said["time_offset_s"] == -0.003);

    CalibrationEstimate estimate;
    estimate.correction.time_offset_s = 0.002;
    estimate.sigma(kTimeOffset) = 1e-4;
    estimate.correction.lens[1](kLensPrincipal) = 0.3;
    const json calibration = json::parse(calibration_message(kStamp, estimate));
    CHECK(calibration["time_offset"] == 0.002);
    CHECK(calibration["time_offset_sigma"] == 1e-4);
    CHECK(calibration["right_cx"] == 0.3);
    CHECK(calibration["left_cx"] == 0.0);
    const json schema = json::parse(schema_text(FoxgloveSchema::kCalibration));
    CHECK(schema["properties"]["right_cx"]["description"] == "correction of the calibration as given (px)");
    CHECK(schema["properties"]["mount_p_z"]["description"] == "correction of the calibration as given (m)");

    MessageTimes times{};
    times[0] = {5.0, 4.5};
    times[1] = {3.0, 2.5};
    times[2 + static_cast<std::size_t>(Stage::kMesh)] = {1.0, 0.75};
    const json timing = json::parse(timing_message(kStamp, true, times));
    CHECK(timing["is_keyframe"] == true);
    CHECK(timing["total_ms"] == 5.0);
    CHECK(timing["total_cpu_ms"] == 4.5);
    CHECK(timing["estimate_ms"] == 3.0);
    CHECK(timing["mesh_cpu_ms"] == 0.75);
}

}  // namespace
}  // namespace facet::messages_test
