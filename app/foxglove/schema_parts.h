// SPDX-License-Identifier: BSD-2-Clause
// What JSON schemas of messages are put together from.
#pragma once

#include <initializer_list>
#include <nlohmann/json.hpp>
#include <utility>

/// Reentrant. Heap.
namespace facet::schema_parts {

using Json = nlohmann::ordered_json;

inline Json number() { return {{"type", "number"}}; }
inline Json text() { return {{"type", "string"}}; }
inline Json boolean() { return {{"type", "boolean"}}; }
/// An integer that is not negative.
inline Json count() { return {{"type", "integer"}, {"minimum", 0}}; }
inline Json list_of(Json items) { return {{"type", "array"}, {"items", std::move(items)}}; }

inline Json described(Json type, const std::string& words) {
    type["description"] = words;
    return type;
}

/// An object that has all of these properties.
inline Json object(const char* title, std::initializer_list<std::pair<const char*, Json>> properties) {
    Json made{{"title", title}, {"type", "object"}, {"properties", Json::object()}, {"required", Json::array()}};
    for (const auto& [name, type] : properties) {
        made["properties"][name] = type;
        made["required"].push_back(name);
    }
    return made;
}

/// A stamp, or a span of time, as seconds and nanoseconds.
inline Json seconds_and_rest(const char* title, Json seconds) {
    Json rest = count();
    rest["maximum"] = 999'999'999;
    return {{"type", "object"}, {"title", title}, {"properties", {{"sec", std::move(seconds)}, {"nsec", rest}}}};
}
inline Json time() { return seconds_and_rest("time", count()); }
inline Json duration() { return seconds_and_rest("duration", {{"type", "integer"}}); }

inline Json vector3() { return object("foxglove.Vector3", {{"x", number()}, {"y", number()}, {"z", number()}}); }
inline Json quaternion() {
    return object("foxglove.Quaternion", {{"x", number()}, {"y", number()}, {"z", number()}, {"w", number()}});
}

}  // namespace facet::schema_parts
