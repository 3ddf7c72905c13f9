// SPDX-License-Identifier: BSD-2-Clause
// The messages that Foxglove and its like are given, live or in a log: their topics, and their schemas as JSON Schema.
#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace facet {

/// The first five are Foxglove's own (docs.foxglove.dev/docs/sdk/schemas), the others ours.
enum class FoxgloveSchema : std::uint8_t {
    kPoseInFrame,
    kPosesInFrame,
    kFrameTransform,
    kSceneUpdate,
    kCompressedImage,
    kHealth,
    kCalibration,
    kTiming,
    kCount
};

/// Every topic has one schema. kTransforms has the body in the world at each frame and the camera on the body at each
/// keyframe.
enum class FoxgloveTopic : std::uint8_t {
    kPose,
    kPath,
    kTransforms,
    kMesh,
    kPlanes,
    kImage,
    kHealth,
    kCalibration,
    kTiming,
    kCount
};

inline constexpr std::size_t kFoxgloveTopics = static_cast<std::size_t>(FoxgloveTopic::kCount);

struct FoxgloveTopicInfo {
    const char* name;
    FoxgloveSchema schema;
};

/// In the order of FoxgloveTopic.
inline constexpr std::array<FoxgloveTopicInfo, kFoxgloveTopics> kFoxgloveTopicInfos{{
    {"/pose", FoxgloveSchema::kPoseInFrame},
    {"/path", FoxgloveSchema::kPosesInFrame},
    {"/tf", FoxgloveSchema::kFrameTransform},
    {"/mesh", FoxgloveSchema::kSceneUpdate},
    {"/planes", FoxgloveSchema::kSceneUpdate},
    {"/image", FoxgloveSchema::kCompressedImage},
    {"/health", FoxgloveSchema::kHealth},
    {"/calibration", FoxgloveSchema::kCalibration},
    {"/timing", FoxgloveSchema::kTiming},
}};

/// As messages and schemas are encoded.
inline constexpr const char* kFoxgloveEncoding = "json";
inline constexpr const char* kFoxgloveSchemaEncoding = "jsonschema";

/// Frames that messages name: W, B, and the camera that the image is of.
inline constexpr const char* kWorldFrame = "world";
inline constexpr const char* kBodyFrame = "body";
inline constexpr const char* kCameraFrame = "camera";

/// "foxglove.PoseInFrame", "facet.Health" and so on. Reentrant. No heap.
const char* schema_name(FoxgloveSchema schema);

/// The schema itself, complete: Foxglove's own ones as published, without their descriptions. Reentrant. Heap.
std::string schema_text(FoxgloveSchema schema);

}  // namespace facet
