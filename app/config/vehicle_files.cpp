// SPDX-License-Identifier: BSD-2-Clause
#include "app/config/vehicle_files.h"

#include <array>
#include <optional>
#include <span>

#include "app/support/yaml_file.h"

namespace facet {
namespace {

using Keys = std::span<const char* const>;

/// The text at a path of keys, such as imu, can, dbc; nothing if it is not there. Goes down by calls, because assigning
/// a node of yaml-cpp changes the tree that it belongs to.
std::optional<std::string> text_at(const YamlNode& node, Keys keys) {
    if (keys.empty()) {
        return node.text();
    }
    return node.has(keys.front()) ? text_at(node.at(keys.front()), keys.subspan(1)) : std::nullopt;
}

}  // namespace

std::vector<std::string> files_named_by(const std::string& vehicle_file) {
    const YamlNode root = load_yaml(vehicle_file);
    std::vector<std::string> files;
    constexpr std::array kRig{"calibration", "euroc"};
    if (const auto folder = text_at(root, kRig)) {
        for (const char* sensor : {"cam0", "cam1", "imu0"}) {
            files.push_back(*folder + "/" + sensor + "/sensor.yaml");
        }
    }
    const std::vector<std::vector<const char*>> places{{"calibration", "camchain"},
                                                       {"calibration", "imu"},
                                                       {"estimator", "config"},
                                                       {"imu", "can", "dbc"},
                                                       {"sinks", "mavlink", "signing", "key_file"}};
    for (const std::vector<const char*>& keys : places) {
        if (const auto file = text_at(root, keys)) {
            files.push_back(*file);
        }
    }
    return files;
}

}  // namespace facet
