// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/plane_file.h"

#include <fmt/core.h>

#include <cmath>
#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>

#include "app/support/input_error.h"
#include "platform/base/regular_file.h"

namespace facet {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kUnitTolerance = 1e-3;
constexpr double kFar_m = 1e9;

/// One entry of the array; its errors name it.
class PlaneEntry {
public:
    PlaneEntry(const std::string& path, std::size_t index, const Json& json) : path_(path), index_(index), json_(json) {
        if (!json.is_object()) {
            fail("is not an object");
        }
    }

    /// @param distance  name of the member that holds the distance
    EvalPlane plane(const char* distance) const {
        EvalPlane plane;
        plane.name = name();
        plane.normal = unit_vector("normal");
        plane.distance = number(distance);
        plane.seen_m2 = json_.contains("seen_area") ? number("seen_area") : 0.0;
        if (json_.contains("min") && json_.contains("max")) {
            plane.box = {vector("min"), vector("max")};
        }
        plane.id = id();
        if (json_.contains("regions")) {
            plane.outline = outline();
            if (json_.contains("sigma") && json_.contains("sigma_turn")) {
                plane.claim = {plane.outline.origin, plane.outline.axes, number("sigma"),
                               numbers<2>(json_.at("sigma_turn"), "sigma_turn")};
            }
        }
        return plane;
    }

private:
    [[noreturn]] void fail(const std::string& what) const {
        throw InputError(fmt::format("{}: entry {} {}", path_, index_, what));
    }

    std::string name() const {
        if (const auto at = json_.find("name"); at != json_.end()) {
            if (!at->is_string()) {
                fail("has a name that is not text");
            }
            return at->get<std::string>();
        }
        const std::optional<std::uint64_t> number = id();
        return number.has_value() ? fmt::format("plane {}", *number) : std::string();
    }

    std::optional<std::uint64_t> id() const {
        const auto at = json_.find("id");
        if (at == json_.end()) {
            return std::nullopt;
        }
        if (!at->is_number_unsigned()) {
            fail("has an id that is not a natural number");
        }
        return at->get<std::uint64_t>();
    }

    PlaneOutline outline() const {
        PlaneOutline outline;
        outline.origin = vector("origin");
        const Json& axes = list(json_, "axes");
        if (axes.size() != 2) {
            fail("has no two \"axes\"");
        }
        for (std::size_t i = 0; i < 2; ++i) {
            outline.axes[i] = numbers<3>(axes[i], "axes");
        }
        for (const Json& region : list(json_, "regions")) {
            outline.lines.push_back(corners(list(region, "boundary")));
            for (const Json& hole : list(region, "holes")) {
                outline.lines.push_back(corners(hole));
            }
        }
        return outline;
    }

    const Json& list(const Json& parent, const char* member) const {
        if (!parent.is_object() || !parent.contains(member) || !parent.at(member).is_array()) {
            fail(fmt::format("has no list \"{}\"", member));
        }
        return parent.at(member);
    }

    std::vector<Eigen::Vector2d> corners(const Json& line) const {
        if (!line.is_array()) {
            fail("has a region without corners");
        }
        std::vector<Eigen::Vector2d> corners;
        for (const Json& corner : line) {
            corners.emplace_back(numbers<2>(corner, "corner"));
        }
        return corners;
    }

    double number(const char* member) const {
        const auto at = json_.find(member);
        if (at == json_.end() || !at->is_number()) {
            fail(fmt::format("has no number \"{}\"", member));
        }
        return at->get<double>();
    }

    Eigen::Vector3d vector(const char* member) const {
        const auto at = json_.find(member);
        return numbers<3>(at != json_.end() ? *at : Json(), member);
    }

    template <int kCount>
    Eigen::Vector<double, kCount> numbers(const Json& json, const char* what) const {
        Eigen::Vector<double, kCount> v;
        bool is_good = json.is_array() && json.size() == kCount;
        for (int i = 0; i < kCount && is_good; ++i) {
            const Json& number = json[static_cast<std::size_t>(i)];
            is_good = number.is_number() && std::abs(number.get<double>()) < kFar_m;
            v[i] = is_good ? number.get<double>() : 0.0;
        }
        if (!is_good) {
            fail(fmt::format("has no \"{}\" of {} numbers", what, kCount == 2 ? "two" : "three"));
        }
        return v;
    }

    Eigen::Vector3d unit_vector(const char* member) const {
        Eigen::Vector3d v = vector(member);
        if (!(std::abs(v.norm() - 1.0) < kUnitTolerance)) {
            fail(fmt::format("has a \"{}\" that is not a unit vector", member));
        }
        return v;
    }

    const std::string& path_;
    std::size_t index_;
    const Json& json_;
};

Json parse_json(std::istream& stream, const std::string& path) {
    try {
        return Json::parse(stream);
    } catch (const Json::exception& e) {
        throw InputError(path + ": " + e.what());
    }
}

}  // namespace

const Eigen::AlignedBox3d EvalPlane::kEverywhere(Eigen::Vector3d::Constant(-kFar_m), Eigen::Vector3d::Constant(kFar_m));

std::vector<EvalPlane> load_planes(const std::string& path) {
    if (const std::string refusal = refuse_file(path); !refusal.empty()) {
        throw InputError(path + ": " + refusal);
    }
    std::ifstream file(path);
    if (!file) {
        return {};
    }
    const Json root = parse_json(file, path);
    const bool is_older_form = root.is_object() && root.contains("planes");
    const Json& list = is_older_form ? root.at("planes") : root;
    if (!list.is_array()) {
        throw InputError(path + ": not an array of planes");
    }
    std::vector<EvalPlane> planes;
    for (const Json& item : list) {
        planes.push_back(PlaneEntry(path, planes.size(), item).plane(is_older_form ? "offset" : "distance"));
    }
    return planes;
}

}  // namespace facet
