// SPDX-License-Identifier: BSD-2-Clause
#include "app/foxglove/schemas.h"

#include "app/foxglove/own_schemas.h"
#include "app/foxglove/schema_parts.h"

namespace facet {
namespace {

using namespace schema_parts;  // NOLINT(google-build-using-namespace): the vocabulary of everything below

Json pose() { return object("foxglove.Pose", {{"position", vector3()}, {"orientation", quaternion()}}); }

Json point() { return object("foxglove.Point3", {{"x", number()}, {"y", number()}, {"z", number()}}); }

Json colour() { return object("foxglove.Color", {{"r", number()}, {"g", number()}, {"b", number()}, {"a", number()}}); }

Json bytes() { return {{"type", "string"}, {"contentEncoding", "base64"}}; }

/// One of several constants: each of them is named and has its place as its value.
Json choice(const char* title, std::initializer_list<const char*> names) {
    Json values = Json::array();
    for (const char* name : names) {
        values.push_back({{"title", name}, {"const", static_cast<int>(values.size())}});
    }
    return {{"title", title}, {"oneOf", values}};
}

Json deletion() {
    return object("foxglove.SceneEntityDeletion",
                  {{"timestamp", time()},
                   {"type", choice("foxglove.SceneEntityDeletionType", {"MATCHING_ID", "ALL"})},
                   {"id", text()}});
}

Json arrow() {
    return object("foxglove.ArrowPrimitive", {{"pose", pose()},
                                              {"shaft_length", number()},
                                              {"shaft_diameter", number()},
                                              {"head_length", number()},
                                              {"head_diameter", number()},
                                              {"color", colour()}});
}

/// A cube or a sphere.
Json solid(const char* title) { return object(title, {{"pose", pose()}, {"size", vector3()}, {"color", colour()}}); }

Json cylinder() {
    return object("foxglove.CylinderPrimitive", {{"pose", pose()},
                                                 {"size", vector3()},
                                                 {"bottom_scale", number()},
                                                 {"top_scale", number()},
                                                 {"color", colour()}});
}

Json line() {
    return object("foxglove.LinePrimitive",
                  {{"type", choice("foxglove.LineType", {"LINE_STRIP", "LINE_LOOP", "LINE_LIST"})},
                   {"pose", pose()},
                   {"thickness", number()},
                   {"scale_invariant", boolean()},
                   {"points", list_of(point())},
                   {"color", colour()},
                   {"colors", list_of(colour())},
                   {"indices", list_of(count())}});
}

Json triangles() {
    return object("foxglove.TriangleListPrimitive", {{"pose", pose()},
                                                     {"points", list_of(point())},
                                                     {"color", colour()},
                                                     {"colors", list_of(colour())},
                                                     {"indices", list_of(count())}});
}

Json label() {
    return object("foxglove.TextPrimitive", {{"pose", pose()},
                                             {"billboard", boolean()},
                                             {"font_size", number()},
                                             {"scale_invariant", boolean()},
                                             {"color", colour()},
                                             {"text", text()}});
}

Json model() {
    return object("foxglove.ModelPrimitive", {{"pose", pose()},
                                              {"scale", vector3()},
                                              {"color", colour()},
                                              {"override_color", boolean()},
                                              {"url", text()},
                                              {"media_type", text()},
                                              {"data", bytes()}});
}

Json entity() {
    return object("foxglove.SceneEntity",
                  {{"timestamp", time()},
                   {"frame_id", text()},
                   {"id", text()},
                   {"lifetime", duration()},
                   {"frame_locked", boolean()},
                   {"metadata", list_of(object("foxglove.KeyValuePair", {{"key", text()}, {"value", text()}}))},
                   {"arrows", list_of(arrow())},
                   {"cubes", list_of(solid("foxglove.CubePrimitive"))},
                   {"spheres", list_of(solid("foxglove.SpherePrimitive"))},
                   {"cylinders", list_of(cylinder())},
                   {"lines", list_of(line())},
                   {"triangles", list_of(triangles())},
                   {"texts", list_of(label())},
                   {"models", list_of(model())}});
}

Json schema_of(FoxgloveSchema schema) {
    const char* const name = schema_name(schema);
    switch (schema) {
        case FoxgloveSchema::kPoseInFrame:
            return object(name, {{"timestamp", time()}, {"frame_id", text()}, {"pose", pose()}});
        case FoxgloveSchema::kPosesInFrame:
            return object(name, {{"timestamp", time()}, {"frame_id", text()}, {"poses", list_of(pose())}});
        case FoxgloveSchema::kFrameTransform:
            return object(name, {{"timestamp", time()},
                                 {"parent_frame_id", text()},
                                 {"child_frame_id", text()},
                                 {"translation", vector3()},
                                 {"rotation", quaternion()}});
        case FoxgloveSchema::kSceneUpdate:
            return object(name, {{"deletions", list_of(deletion())}, {"entities", list_of(entity())}});
        case FoxgloveSchema::kCompressedImage:
            return object(name, {{"timestamp", time()}, {"frame_id", text()}, {"data", bytes()}, {"format", text()}});
        case FoxgloveSchema::kHealth: return health_schema(name);
        case FoxgloveSchema::kCalibration: return calibration_schema(name);
        case FoxgloveSchema::kTiming: return timing_schema(name);
        case FoxgloveSchema::kCount: break;
    }
    return {};
}

}  // namespace

const char* schema_name(FoxgloveSchema schema) {
    switch (schema) {
        case FoxgloveSchema::kPoseInFrame: return "foxglove.PoseInFrame";
        case FoxgloveSchema::kPosesInFrame: return "foxglove.PosesInFrame";
        case FoxgloveSchema::kFrameTransform: return "foxglove.FrameTransform";
        case FoxgloveSchema::kSceneUpdate: return "foxglove.SceneUpdate";
        case FoxgloveSchema::kCompressedImage: return "foxglove.CompressedImage";
        case FoxgloveSchema::kHealth: return "facet.Health";
        case FoxgloveSchema::kCalibration: return "facet.Calibration";
        case FoxgloveSchema::kTiming: return "facet.Timing";
        case FoxgloveSchema::kCount: break;
    }
    return "?";
}

std::string schema_text(FoxgloveSchema schema) { return schema_of(schema).dump(); }

}  // namespace facet
