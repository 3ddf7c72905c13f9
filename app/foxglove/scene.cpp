// SPDX-License-Identifier: BSD-2-Clause
#include "app/foxglove/scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <numeric>
#include <vector>

#include "app/foxglove/json_values.h"

namespace facet {
namespace {

/// After Okabe and Ito; the last three are ours.
constexpr std::array<std::uint32_t, 10> kPlaneColours{0x0072b2, 0xe69f00, 0x009e73, 0xcc79a7, 0x56b4e9,
                                                      0xd55e00, 0xe5d43c, 0x8c6bb1, 0x7f9c1e, 0xa65628};
constexpr std::array<float, 3> kOnNoPlane{0.78F, 0.80F, 0.82F};
constexpr const char* kAtOrigin = R"({"position":{"x":0,"y":0,"z":0},"orientation":{"x":0,"y":0,"z":0,"w":1}})";
constexpr float kOpaque = 1.0F;
constexpr float kTransparent = 0.35F;

std::string colour_text(std::int32_t plane, float alpha) {
    const std::array<float, 3> c = plane < 0 ? kOnNoPlane : plane_colour(plane);
    return fmt::format(R"({{"r":{:.3f},"g":{:.3f},"b":{:.3f},"a":{:.2f}}})", c[0], c[1], c[2], alpha);
}

void add_point(std::string& list, const Eigen::Vector3f& p) {
    fmt::format_to(std::back_inserter(list), R"({}{{"x":{:.4f},"y":{:.4f},"z":{:.4f}}})", list.empty() ? "" : ",",
                   p.x(), p.y(), p.z());
}

void add_triangles(std::string& list, const std::string& points, const std::string& colour) {
    fmt::format_to(std::back_inserter(list), R"({}{{"pose":{},"points":[{}],"color":{},"colors":[],"indices":[]}})",
                   list.empty() ? "" : ",", kAtOrigin, points, colour);
}

/// A message with one entity.
std::string scene_text(Timestamp stamp, const char* frame, const char* id, const std::string& triangles,
                       const std::string& texts) {
    return fmt::format(
        R"({{"deletions":[],"entities":[{{"timestamp":{},"frame_id":"{}","id":"{}","lifetime":{{"sec":0,"nsec":0}},)"
        R"("frame_locked":true,"metadata":[],"arrows":[],"cubes":[],"spheres":[],"cylinders":[],"lines":[],)"
        R"("triangles":[{}],"texts":[{}],"models":[]}}]}})",
        json_values::stamp(stamp).dump(), frame, id, triangles, texts);
}

bool is_finite(const SceneFace& face) {
    return std::ranges::all_of(face.p_W, [](const Eigen::Vector3f& p) { return p.allFinite(); });
}

}  // namespace

std::array<float, 3> plane_colour(std::int32_t id) {
    const auto place = static_cast<std::uint32_t>(id);
    const std::uint32_t colour = kPlaneColours[place % kPlaneColours.size()];
    const float lighter = place / kPlaneColours.size() % 2 == 0 ? 0.0F : 0.25F;
    const auto part = [&](unsigned shift) {
        const float value = static_cast<float>((colour >> shift) & 0xffU) / 255.0F;
        return value + lighter * (1.0F - value);
    };
    return {part(16), part(8), part(0)};
}

std::string mesh_scene(Timestamp stamp, const char* frame, std::span<const SceneFace> faces) {
    std::vector<std::size_t> order(faces.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, {}, [&](std::size_t i) { return faces[i].plane; });
    std::string triangles;
    std::string points;
    for (std::size_t k = 0; k < order.size(); ++k) {
        const SceneFace& face = faces[order[k]];
        if (is_finite(face)) {
            std::ranges::for_each(face.p_W, [&](const Eigen::Vector3f& p) { add_point(points, p); });
        }
        const bool is_last = k + 1 == order.size() || faces[order[k + 1]].plane != face.plane;
        if (is_last && !points.empty()) {
            add_triangles(triangles, points, colour_text(face.plane, kOpaque));
            points.clear();
        }
    }
    return scene_text(stamp, frame, "mesh", triangles, "");
}

std::string planes_scene(Timestamp stamp, const char* frame, std::span<const ScenePlane> planes) {
    std::string triangles;
    std::string texts;
    for (const ScenePlane& plane : planes) {
        const Eigen::Vector3f a = plane.centre_W - plane.along_W - plane.across_W;
        const Eigen::Vector3f b = plane.centre_W + plane.along_W - plane.across_W;
        const Eigen::Vector3f c = plane.centre_W + plane.along_W + plane.across_W;
        const Eigen::Vector3f d = plane.centre_W - plane.along_W + plane.across_W;
        if (!(a.allFinite() && b.allFinite() && c.allFinite() && d.allFinite())) {
            continue;
        }
        std::string points;
        for (const Eigen::Vector3f& p : {a, b, c, a, c, d}) {
            add_point(points, p);
        }
        add_triangles(triangles, points, colour_text(plane.id, kTransparent));
        fmt::format_to(std::back_inserter(texts),
                       R"({}{{"pose":{},"billboard":true,"font_size":14,"scale_invariant":true,"color":{},)"
                       R"("text":"{} {}"}})",
                       texts.empty() ? "" : ",",
                       json_values::pose({Eigen::Quaterniond::Identity(), plane.centre_W.cast<double>()}).dump(),
                       colour_text(plane.id, kOpaque), to_string(plane.kind), plane.id);
    }
    return scene_text(stamp, frame, "planes", triangles, texts);
}

}  // namespace facet
