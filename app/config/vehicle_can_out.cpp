// SPDX-License-Identifier: BSD-2-Clause
#include "app/config/vehicle_can_out.h"

#include <fmt/core.h>

#include <array>
#include <string_view>

#include "app/support/yaml_section.h"

namespace facet {

CanOutOptions read_can_out(const YamlNode& node) {
    CanOutOptions out;
    YamlSection section(node);
    out.interface = section.at("interface").text();
    constexpr std::array<std::string_view, 3> kFormats{"auto", "classic", "fd"};
    out.format = static_cast<CanOutFormat>(section.choice("format", kFormats, 0));
    section.read("bit_rate_switch", out.bit_rate_switch);
    constexpr int kHighestId = 0x7FF;
    int first_id = static_cast<int>(out.first_id);
    section.read("first_id", first_id, 0, kHighestId - static_cast<int>(kCanOutIds) + 1);
    out.first_id = static_cast<std::uint32_t>(first_id);
    section.read("every", out.every, 1, 1000);
    section.read("send_lost", out.send_lost);
    int node_id = 0;
    section.read("dronecan_node_id", node_id, 0, 127);
    out.node_id = static_cast<std::uint8_t>(node_id);
    section.finish();
    return out;
}

void check_can_nodes(const YamlNode& node, const Vehicle& vehicle) {
    const int ours = vehicle.can_out->node_id;
    const bool is_shared = vehicle.imu_can && vehicle.imu_can->source.socket.interface == vehicle.can_out->interface;
    if (ours != 0 && is_shared && vehicle.imu_can->protocol == CanProtocol::kDroneCan &&
        vehicle.imu_can->dronecan.node_id == ours) {
        node.fail(fmt::format("dronecan_node_id {} is that of the IMU on the same bus", ours));
    }
}

}  // namespace facet
