// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/plane_file.h"

#include <fmt/core.h>

#include <cmath>
#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>

#include "app/support/input_error.h"

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
        return plane;
    }

private:
    [[noreturn]] void fail(const std::string& what) const {
        throw InputError(fmt::format("{}: entry {} {}", path_, index_, what));
    }

    std::string name() const {
        if (const auto at = json_.find("name"); at != json_.end()) {
            if (!at->is_string()) {
                fail("has a name that is no text");
            }
            return at->get<std::string>();
        }
        if (const auto at = json_.find("id"); at != json_.end()) {
            if (!at->is_number_unsigned()) {
                fail("has an id that is not a natural number");
            }
            return fmt::format("plane {}", at->get<std::uint64_t>());
        }
        return {};
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
        if (at == json_.end() || !at->is_array() || at->size() != 3) {
            fail(fmt::format("has no \"{}\" of three numbers", member));
        }
        Eigen::Vector3d v;
        for (std::size_t i = 0; i < 3; ++i) {
            const Json& component = (*at)[i];
            if (!component.is_number()) {
                fail(fmt::format("has no \"{}\" of three numbers", member));
            }
            v[static_cast<Eigen::Index>(i)] = component.get<double>();
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
